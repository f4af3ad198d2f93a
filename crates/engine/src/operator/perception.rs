use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use trocar_core::lane::{Lane, Mask};
use trocar_core::time::nearest_ticks;

const DRAWN: usize = 64;

/// Separates these random numbers from others with the same seed.
const DOMAIN: u64 = 0x7065_7263_6569;

const IN_PROGRESS: f64 = 0.5;

const CUE_TAKEN_UP: f64 = 0.5;

trocar_core::choice! {
    /// Let the operator notice a drop of the felt force by the fixed threshold of the reaction, or by a psychometric
    /// decision.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Perception at "perception.kind" = None {
        "none" => None,
        "psychometric" => Psychometric(PerceptionSettings),
    }
}

trocar_core::settings! {
    /// Just noticeable difference (d' = 1): 7 % of a force of 2.5 to 10 N (Pang, Tan and Durlach 1991), also for the
    /// elbow (Jones 1989). Lapses are usually below 6 % (Wichmann and Hill 2001), reactions to vibration about 0.2 s
    /// (Bao et al. 2019). The others are chosen here.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct PerceptionSettings in "perception." {
        /// Standard deviation of the internal noise, as a fraction of the felt force.
        weber_fraction: f64 [POSITIVE_SHARE] = 0.07,
        /// Force added to the felt force in Weber's law, which gives small forces an absolute threshold.
        absolute_force_n: f64 [NON_NEGATIVE] = 0.3,
        /// Criterion of the decision, in standard deviations of the internal noise.
        criterion: f64 [NON_NEGATIVE] = 2.5,
        /// Share of the changes that remain unnoticed, independent of their size.
        lapse_rate: f64 [SHARE] = 0.02,
        /// Time constant over which the felt force is integrated.
        integration_s: f64 [POSITIVE] = 0.05,
        /// Time constant of the memory that the felt force is compared with.
        memory_s: f64 [POSITIVE] = 0.5,
        /// Time after which the internal noise is drawn again.
        interval_s: f64 [POSITIVE] = 0.5,
        /// Mean of the time from noticing to the reaction.
        reaction_mean_s: f64 [NON_NEGATIVE] = 0.2,
        /// Standard deviation of the time to the reaction.
        reaction_std_s: f64 [NON_NEGATIVE] = 0.04,
        /// Minimum time from noticing to the reaction.
        reaction_min_s: f64 [NON_NEGATIVE] = 0.1,
    }
    where memory_s: |s| s.memory_s > s.integration_s, "above perception.integration_s";
}

impl Perception {
    pub fn settings(&self) -> Option<&PerceptionSettings> {
        match self {
            Self::None => None,
            Self::Psychometric(settings) => Some(settings),
        }
    }
}

impl PerceptionSettings {
    pub(super) fn reaction_ticks<const N: usize>(&self, seed: u64, stream: u64, tick_s: f64) -> [f64; N] {
        let mut rng = rng(seed ^ 1, stream);
        std::array::from_fn(|_| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            let reaction_s = (self.reaction_mean_s + self.reaction_std_s * normal).max(self.reaction_min_s);
            nearest_ticks(reaction_s, tick_s) as f64
        })
    }

    fn step_share(&self) -> f64 {
        let (fast, slow) = (self.integration_s, self.memory_s);
        let peak_s = fast * slow / (slow - fast) * libm::log(slow / fast);
        libm::exp(-peak_s / slow) - libm::exp(-peak_s / fast)
    }
}

fn rng(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ DOMAIN);
    rng.set_stream(stream);
    rng
}

/// ```text
/// S = F_h + exp(-T/τ_i) (S - F_h)        integrated force
/// L = F_h + exp(-T/τ_m) (L - F_h)        memory
/// x = (L - S) / (h w (L₀ + F_a))         evidence in units of the noise
/// noticed:  x >= c + z,  z normal with mean 0 and standard deviation 1
/// ```
/// A drop by `ΔF`, of which `L - S` reaches the share `h`, is noticed with the probability
/// `(1 - λ) Φ(ΔF / w (F + F_a) - c)`. `L₀` is the memory at the beginning of the change; `z` is drawn once per
/// interval, infinite with the probability `λ`.
#[derive(Debug, Clone)]
pub(super) struct Noticing<L: Lane> {
    keep_integrated: L,
    keep_memory: L,
    /// `1 / (h w)`.
    gain: L,
    absolute: L,
    interval_ticks: L,
    criteria: [L; DRAWN],
    drawn: L,
    criterion: L,
    next_draw: L,
    integrated: L,
    memory: L,
    reference: L,
    evidence: L,
    cue: L,
    cue_is_used: L::Mask,
    is_first: L::Mask,
}

impl<L: Lane> Noticing<L> {
    pub(super) fn new(settings: &PerceptionSettings, seed: u64, first_stream: u64, tick_s: f64) -> Self {
        let mut criteria = [L::zero(); DRAWN];
        for lane in 0..L::WIDTH {
            let mut rng = rng(seed, first_stream + lane as u64);
            for drawn in &mut criteria {
                let lapses = rng.random::<f64>() < settings.lapse_rate;
                let normal: f64 = StandardNormal.sample(&mut rng);
                let criterion = if lapses { f64::INFINITY } else { settings.criterion + normal };
                *drawn = drawn.with_lane(lane, criterion);
            }
        }
        let keep = |time_constant_s: f64| L::splat(libm::exp(-tick_s / time_constant_s));
        Self {
            keep_integrated: keep(settings.integration_s),
            keep_memory: keep(settings.memory_s),
            gain: L::splat(1.0 / (settings.step_share() * settings.weber_fraction)),
            absolute: L::splat(settings.absolute_force_n),
            interval_ticks: L::splat(nearest_ticks(settings.interval_s, tick_s).max(1) as f64),
            criteria,
            drawn: L::zero(),
            criterion: L::splat(f64::INFINITY),
            next_draw: L::zero(),
            integrated: L::zero(),
            memory: L::zero(),
            reference: L::zero(),
            evidence: L::zero(),
            cue: L::zero(),
            cue_is_used: L::Mask::splat(false),
            is_first: L::Mask::splat(true),
        }
    }

    /// A falling force is expected while the operator withdraws.
    #[inline(always)]
    pub(super) fn step(&mut self, now: L, felt: L, cue: L::Mask, withdraws: L::Mask) -> L::Mask {
        let (zero, one) = (L::zero(), L::splat(1.0));
        let in_progress = self.evidence.gt(L::splat(IN_PROGRESS));
        let draws = now.ge(self.next_draw) & !in_progress;
        if draws.any() {
            self.draw(draws, now);
        }
        self.integrated = L::select(self.is_first, felt, felt + self.keep_integrated * (self.integrated - felt));
        self.memory = L::select(self.is_first, felt, felt + self.keep_memory * (self.memory - felt));
        self.is_first = L::Mask::splat(false);
        self.reference = L::select(in_progress, self.reference, self.memory);
        let scale = (self.reference.abs() + self.absolute).max(L::splat(f64::MIN_POSITIVE));
        self.evidence = L::select(withdraws, zero, self.gain * (self.memory - self.integrated) / scale);
        let aim = L::select(cue, one, zero);
        self.cue = aim + self.keep_integrated * (self.cue - aim);
        self.cue_is_used = self.cue_is_used & cue;
        let attends = self.criterion.lt(L::splat(f64::INFINITY));
        let feels_cue = cue & self.cue.ge(L::splat(CUE_TAKEN_UP)) & !self.cue_is_used;
        (self.evidence.ge(self.criterion) & !withdraws) | (feels_cue & attends)
    }

    #[inline(always)]
    pub(super) fn use_cue(&mut self, noticed: L::Mask) {
        self.cue_is_used = self.cue_is_used | noticed;
    }

    #[inline(always)]
    pub(super) fn restart(&mut self, lanes: L::Mask, now: L, felt: L) {
        self.integrated = L::select(lanes, felt, self.integrated);
        self.memory = L::select(lanes, felt, self.memory);
        self.evidence = L::select(lanes, L::zero(), self.evidence);
        self.next_draw = L::select(lanes, now, self.next_draw);
    }

    #[cold]
    #[inline(never)]
    fn draw(&mut self, draws: L::Mask, now: L) {
        for lane in (0..L::WIDTH).filter(|&lane| draws.lane(lane)) {
            let count = self.drawn.lane(lane);
            self.criterion = self.criterion.with_lane(lane, self.criteria[count as usize % DRAWN].lane(lane));
            self.drawn = self.drawn.with_lane(lane, count + 1.0);
        }
        self.next_draw = L::select(draws, now + self.interval_ticks, self.next_draw);
    }
}

trocar_core::lane::gather!(Noticing {
    keep_integrated, keep_memory, gain, absolute, interval_ticks, criteria, drawn, criterion, next_draw, integrated, memory,
    reference, evidence, cue,
} masks { cue_is_used, is_first });

#[cfg(test)]
mod tests {
    use super::*;

    /// The share of `trials` sudden drops, by a share of the force, that is noticed within one interval.
    fn noticed(settings: &PerceptionSettings, drop: f64, trials: u64) -> f64 {
        let is_noticed = |seed: &u64| {
            let mut person = Noticing::<f64>::new(settings, *seed, 0, 1e-3);
            (0..900)
                .any(|tick| person.step(tick as f64, if tick < 50 { 4.0 } else { 4.0 * (1.0 - drop) }, false, false))
        };
        (0..trials).filter(is_noticed).count() as f64 / trials as f64
    }

    fn settings() -> PerceptionSettings {
        PerceptionSettings { interval_s: 1.0, absolute_force_n: 0.0, ..PerceptionSettings::DEFAULT }
    }

    #[test]
    fn ten_thousand_trials_reproduce_the_configured_threshold_and_slope() {
        use trocar_base::quantiles::normal_quantile;
        for (weber_fraction, criterion, lapse_rate) in [(0.07, 2.5, 0.02), (0.1, 2.0, 0.0)] {
            let settings = PerceptionSettings { weber_fraction, criterion, lapse_rate, ..settings() };
            // The probits of five drops, weighted by their precision, lie on a line with slope 1 / w through the
            // threshold.
            let (mut sums, each) = ([0.0; 5], 2000);
            for step in -2..=2 {
                let drop = weber_fraction * (criterion + 0.6 * f64::from(step));
                let share = noticed(&settings, drop, each) / (1.0 - lapse_rate);
                let probit = normal_quantile(share);
                let weight = (-probit * probit).exp() / (share * (1.0 - share));
                for (sum, term) in sums.iter_mut().zip([1.0, drop, probit, drop * drop, drop * probit]) {
                    *sum += weight * term;
                }
            }
            let [n, x, y, xx, xy] = sums;
            let slope = (n * xy - x * y) / (n * xx - x * x);
            let threshold = (x - y / slope) / n;
            assert!((slope * weber_fraction - 1.0).abs() < 0.03, "slope {slope}, {}", 1.0 / weber_fraction);
            assert!((threshold / (criterion * weber_fraction) - 1.0).abs() < 0.03, "threshold {threshold}");
        }
    }

    #[test]
    fn lapses_limit_the_noticed_share_and_the_criterion_limits_false_notices() {
        let lapsing = PerceptionSettings { lapse_rate: 0.2, ..settings() };
        assert!((noticed(&lapsing, 0.9, 4000) - 0.8).abs() < 0.02);
        // Φ(-1) = 0.159 in an interval without a drop.
        let lax = PerceptionSettings { criterion: 1.0, lapse_rate: 0.0, ..settings() };
        assert!((noticed(&lax, 0.0, 4000) - 0.1587).abs() < 0.02, "{}", noticed(&lax, 0.0, 4000));
    }

    #[test]
    fn a_cue_is_noticed_once_unless_the_person_lapses() {
        let settings = PerceptionSettings { lapse_rate: 0.1, criterion: 6.0, ..settings() };
        let count = |seed: u64| {
            let mut person = Noticing::<f64>::new(&settings, seed, 0, 1e-3);
            let times = (0..900).filter(|&tick| {
                let noticed = person.step(f64::from(tick), 4.0, (200..700).contains(&tick), false);
                person.use_cue(noticed);
                noticed
            });
            times.collect::<Vec<_>>()
        };
        let all: Vec<_> = (0..2000).map(count).collect();
        assert!(all.iter().all(|times| times.len() <= 1 && times.iter().all(|time| (230..240).contains(time))));
        let share = all.iter().filter(|times| !times.is_empty()).count() as f64 / 2000.0;
        assert!((share - 0.9).abs() < 0.02, "{share}");
    }

    #[test]
    fn reaction_times_have_the_configured_mean_spread_and_minimum() {
        let times = settings().reaction_ticks::<4000>(1, 0, 1e-3);
        let mean = times.iter().sum::<f64>() / 4000.0;
        let std = (times.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / 4000.0).sqrt();
        assert!((mean - 200.0).abs() < 2.0 && (std - 40.0).abs() < 1.5, "{mean} {std}");
        assert!(times.iter().all(|&time| time >= 100.0));
    }

    fn person() -> Noticing<f64> {
        Noticing::new(&PerceptionSettings { lapse_rate: 0.0, interval_s: 0.1, ..settings() }, 5, 0, 1e-3)
    }

    #[test]
    fn the_criterion_is_drawn_again_after_each_interval_and_kept_during_a_change() {
        let mut person = person();
        let drawn = person.criteria;
        for tick in 0..1000 {
            person.step(f64::from(tick), 4.0, false, false);
            assert_eq!(person.criterion, drawn[tick as usize / 100], "{tick}");
        }
        // A slow loss of force, which gives evidence all the time.
        let mut force = 4.0;
        let mut kept = None;
        for tick in 1000..1400 {
            force *= 0.9995;
            person.step(f64::from(tick), force, false, false);
            if person.evidence > IN_PROGRESS {
                assert_eq!(*kept.get_or_insert(person.criterion), person.criterion, "{tick}");
            }
        }
        assert!(kept.is_some() && person.evidence > IN_PROGRESS, "{}", person.evidence);
    }

    #[test]
    fn after_a_reaction_the_evidence_refers_to_the_present_force() {
        let (mut person, mut other) = (person(), person());
        for tick in 0..300 {
            let force = if tick < 200 { 4.0 } else { 1.0 };
            person.step(f64::from(tick), force, false, false);
            other.step(f64::from(tick), force, false, false);
        }
        assert!(person.evidence > IN_PROGRESS);
        person.restart(true, 300.0, 1.0);
        other.restart(false, 300.0, 1.0);
        person.step(300.0, 1.0, false, false);
        other.step(300.0, 1.0, false, false);
        assert!(person.evidence == 0.0 && person.next_draw == 400.0, "{} {}", person.evidence, person.next_draw);
        assert!(other.evidence > IN_PROGRESS, "in another lane");
    }

    #[test]
    fn the_evidence_of_a_sudden_drop_reaches_its_share_in_units_of_the_noise() {
        // Without an absolute threshold: ΔF / (w F).
        let mut person = person();
        let peak = (0..900).map(|tick| {
            person.step(f64::from(tick), if tick < 50 { 4.0 } else { 3.0 }, false, false);
            person.evidence
        });
        let peak = peak.fold(0.0, f64::max);
        // The memory has lost a little of the force by the tick at which the change counts as begun.
        assert!((0.25 / 0.07..0.251 / 0.07).contains(&peak), "{peak}");
    }

    #[test]
    fn for_an_operator_who_withdraws_a_falling_force_is_no_evidence() {
        let mut person = person();
        let noticed =
            (0..900).any(|tick| person.step(f64::from(tick), if tick < 50 { 4.0 } else { 0.1 }, false, tick > 40));
        assert!(!noticed && person.evidence == 0.0);
    }
}
