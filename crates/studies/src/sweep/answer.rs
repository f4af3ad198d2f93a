use super::{Findings, Influence, Influences, LevelMean, Spread, Summary, number as number_of};
use trocar_document::{plain, show};
use trocar_figures::InfluenceBar;
use trocar_metrics::Unit;
use trocar_scenario::unit_of;

const MAX_METRICS: usize = 4;

/// Share of the variance of a decisive axis.
const MIN_SHARE: f64 = 0.1;

/// Relative to the metric's largest magnitude.
const SMALL_CHANGE: f64 = 0.01;

/// For the first varying metrics in focus: the axis with the largest influence.
pub(super) fn sentences(findings: &Findings) -> Vec<String> {
    let varies = |of: &&Influences| !findings.summaries[of.column].is_unchanged(findings.cases);
    let sentence = |of: &Influences| of_metric(&findings.summaries[of.column], of);
    findings.influences.iter().filter(varies).filter_map(sentence).take(MAX_METRICS).collect()
}

fn of_metric(summary: &Summary, influences: &Influences) -> Option<String> {
    let label = &summary.label;
    if let Some(constancy) = constancy(summary) {
        return Some(format!("Nothing changes {label} by more than {:.0} %{constancy}.", 100.0 * SMALL_CHANGE));
    }
    let strongest = influences.of_axes.first()?;
    let share = strongest.epsilon_squared?;
    let Some([smallest, largest]) = strongest.means.as_ref().filter(|_| share >= MIN_SHARE) else {
        let Spread { quantile_5, quantile_95, .. } = summary.spread?;
        return Some(format!(
            "No single axis explains {label} ({} to {} in 90 % of the cases): seeds, or several axes together, change \
             it.",
            number(quantile_5, summary),
            number(quantile_95, summary)
        ));
    };
    let axis = &strongest.axis;
    let at = |mean: &LevelMean| format!("{} at {}", number(mean.mean, summary), value(mean, axis));
    Some(format!(
        "The strongest influence on {label} is {axis}, with {:.0} % of its variance: on average {} and {}.",
        100.0 * share,
        at(smallest),
        at(largest)
    ))
}

pub(super) fn constancy(summary: &Summary) -> Option<String> {
    let Spread { min, max, .. } = summary.spread?;
    let is_constant = max - min < SMALL_CHANGE * min.abs().max(max.abs());
    is_constant.then(|| format!(" ({} to {})", number(min, summary), number(max, summary)))
}

impl Influence {
    pub(super) fn bar(&self, summary: &Summary) -> InfluenceBar {
        let range = |[low, high]: &[LevelMean; 2]| {
            format!(" (on average {} to {})", number(low.mean, summary), number(high.mean, summary))
        };
        let range = self.means.as_ref().map_or(String::new(), range);
        InfluenceBar {
            title: format!("{}, by {}{range}", summary.label, self.axis),
            share: self.epsilon_squared,
            slope: self.rank_regression,
        }
    }
}

fn number(value: f64, summary: &Summary) -> String {
    let is_flag = summary.unit == Unit::Count && summary.metric.contains("is_");
    if is_flag {
        return format!("in {:.0} % of the cases", 100.0 * value);
    }
    if summary.unit == Unit::Count { plain(value) } else { show(Some(value), summary.unit) }
}

fn value(mean: &LevelMean, axis: &str) -> String {
    let unit = unit_of(axis).map_or(String::new(), |unit| format!(" {unit}"));
    number_of(&mean.at).map_or_else(|| mean.at.to_toml().to_string(), |number| format!("{}{unit}", plain(number)))
}
