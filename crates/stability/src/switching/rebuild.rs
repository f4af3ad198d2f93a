use std::collections::BTreeMap;

use nalgebra::DMatrix;

use super::conditions::{Condition, Conditions, Count, Term, at_entry};
use super::modes::{Modes, Space};
use super::{MAX_PIECES, SwitchingSettings};
use crate::certificate::{Certificate, Choice, Inequality, Lyapunov, MapFactor, State, StateMap, StateSpace, Summand};

impl Conditions {
    pub(super) fn certificate(
        &self,
        modes: &Modes,
        choice: Choice,
        scale: impl Fn(Space) -> DMatrix<f64>,
        functions: Vec<DMatrix<f64>>,
    ) -> Certificate {
        let spaces = self.maps.iter().flat_map(|map| [map.from, map.to]);
        let state = |(name, unit): (String, &str)| State { name, unit: unit.to_owned() };
        let states = |space| modes.names(space).into_iter().map(state).collect();
        let spaces: BTreeMap<String, StateSpace> =
            spaces.map(|space| (name(space), StateSpace { states: states(space), scale: scale(space) })).collect();
        let functions = (self.functions.iter().zip(functions))
            .map(|(function, p)| Lyapunov { name: function.name.clone(), space: name(function.space), p })
            .collect();
        let maps = (self.maps.iter())
            .map(|map| StateMap {
                name: map.name.clone(),
                from: name(map.from),
                to: name(map.to),
                matrix: map.matrix.clone(),
            })
            .collect();
        let inequalities = self.list.iter().map(Condition::inequality).collect();
        Certificate { choice, at_events: self.at_events, spaces, functions, maps, inequalities }
    }
}

fn name(space: Space) -> String {
    format!("{space:?}")
}

impl Condition {
    fn inequality(&self) -> Inequality {
        let factor = |&(map, count): &(usize, Count)| MapFactor { map, is_power: count == Count::Each };
        let summand = |term: &Term| Summand {
            factor: 0.5 * (term.factor.low + term.factor.high),
            function: term.unknown,
            maps: term.maps.iter().map(factor).collect(),
        };
        Inequality {
            name: self.name.to_owned(),
            rows: name(self.rows),
            powers: self.counts,
            terms: self.terms.iter().map(summand).collect(),
        }
    }
}

/// Takes only claims, functions and scales.
pub(crate) fn required(stated: &Certificate, settings: &SwitchingSettings) -> Result<Certificate, String> {
    let choice = stated.choice;
    if settings.keeps_gap() {
        return Err("an event leaves a gap that is kept, which no certificate covers".to_owned());
    }
    check(choice, settings)?;
    let settings = if choice.is_driven {
        SwitchingSettings { loses_contact: true, ..settings.clone() }
    } else {
        settings.with_least_damping()
    };
    let modes = Modes::new(&settings).map_err(|error| error.to_string())?;
    let conditions = Conditions::new(&modes, settings.phases(), choice);
    let nothing = DMatrix::zeros(0, 0);
    let scale = |space| stated.spaces.get(&name(space)).map_or(&nothing, |space| &space.scale).clone();
    let functions =
        stated.functions.iter().map(|function| function.p.clone()).chain(std::iter::repeat(nothing.clone()));
    let functions = functions.take(conditions.functions.len()).collect();
    Ok(conditions.certificate(&modes, choice, scale, functions))
}

fn check(choice: Choice, settings: &SwitchingSettings) -> Result<(), String> {
    let Choice { dwell_ticks, contraction, rate_per_s, bounds_m_per_n, is_driven, hold_s, pieces } = choice;
    let longest = settings.longest_dwell_ticks().max(settings.phases().refractory);
    let is_positive = |value: &f64| *value > 0.0 && value.is_finite();
    let mut ranges = vec![
        ("dwell_ticks", (1..=longest).contains(&dwell_ticks)),
        ("contraction", contraction > 0.0 && contraction <= 1.0),
        ("rate_per_s", rate_per_s >= 0.0 && rate_per_s.is_finite()),
        ("bounds_m_per_n", bounds_m_per_n.is_none_or(|bounds| is_driven && bounds.iter().all(is_positive))),
        ("hold_s", is_positive(&hold_s)),
        ("pieces", (1..=MAX_PIECES).contains(&pieces)),
    ];
    if ranges.iter().all(|(_, is_within)| *is_within) {
        // With the additional force, V must not exceed its bound at an event.
        let at_entry = at_entry(choice, settings.of_loop.tick_s);
        ranges.push(("contraction", at_entry < if is_driven { 1.0 } else { f64::MAX }));
    }
    match ranges.iter().find(|(_, is_within)| !is_within) {
        Some((name, _)) => Err(format!("choice.{name} is outside its range")),
        None => Ok(()),
    }
}
