//! The proof for a gap that is kept (`clutch`): bounds from tick to tick instead of functions.
//!
//! During a freeze the loop's motion decays: it ends with the slave at the held reference and the hand near its desired
//! position. Only the gap `g` and a small rest remain. At the release
//!
//! ```text
//! x = e g + ρ,      |g| <= a,      |ρ_i| <= R_i a
//! ```
//! `max(|g|, |ρ_i| / R_i)` decays from event to event if these bounds at one event imply `κ a` and `κ R_i a` at the
//! next, with `κ < 1`. The next state is linear in `g` and `ρ` for every choice of the tissue, so `|g| = a` is the
//! worst gap.
//!
//! [`Responses`] bounds the motion at each tick of teleoperation. An alarm at any tick from the dwell on freezes the
//! slave within its bounds. The powers of the frozen map give gap and rest at the end of every freeze. All responses
//! are interval enclosures, without a solver.
//!
//! A quadratic function is too conservative: on the softest tissue an event keeps 93 % of the gap, and an ellipsoid
//! around the motion between the soft and stiff ends is more than 7 % too large.

use nalgebra::DMatrix;

use super::modes::{Modes, Space};
use super::responses::{Responses, Start, Track};
use super::scaling::Scales;
use super::settings::Phases;
use crate::StabilityError;
use crate::certificate::Powers;
use crate::certificate::interval::{Enclosure, Interval, magnitude, middle, power, product};
use crate::certificate::{StateMap, StateSpace};
use trocar_base::interrupt;
use trocar_core::augmentation::cross_fade;

/// The allowed rest, relative to the rest after an event.
const ROOM: f64 = 2.0;

/// Maximum growth per event for a certified dwell: well below 1, so every computer finds the same dwell.
const MAX_GROWTH: f64 = 0.999;

/// Relative allowance for the rounding of short sums.
const ROUNDING: f64 = 1e-12;

/// The proof that a kept gap and the motion decay from event to event.
#[derive(Debug, Clone)]
pub struct KeptGap {
    /// Required ticks of teleoperation between two events.
    pub dwell_ticks: u64,
    /// Number of verified conditions: the ticks of the bounds, and the states after each length of the freeze.
    pub conditions: u64,
    /// Bound of the growth per event by ticks of teleoperation, from 1 on; the last one holds for longer dwells.
    growth: Vec<f64>,
    /// `e`: the scaled states at the release per scaled gap.
    pub along: Vec<f64>,
    /// `R`: the rest of the scaled states and of the scaled feedback force, per scaled gap.
    pub rest: Vec<f64>,
    /// Number of ticks with individual bounds.
    pub ticks: u64,
    /// The states of each phase.
    pub spaces: Vec<StateSpace>,
    /// The maps of teleoperation, an alarm, a frozen tick and the release, and the inputs and signals of the tissue.
    pub maps: Vec<StateMap>,
    /// Bounds of the slave's position in m/m and of the feedback force in N/m after the hand is released at a distance.
    pub(super) reach: Option<(f64, f64)>,
}

impl KeptGap {
    /// Bound of the growth per event with at least this many ticks of teleoperation between events.
    #[must_use]
    pub fn growth_after(&self, dwell_ticks: u64) -> f64 {
        let at = (dwell_ticks.max(1) - 1) as usize;
        self.growth.get(at).or(self.growth.last()).copied().unwrap_or(f64::INFINITY)
    }

    /// The proof with the shortest dwell up to `longest`, optionally with bounds after a release of the hand; `None`
    /// without a proof.
    pub(super) fn of(
        modes: &Modes,
        phases: Phases,
        (longest, wants_reach): (u64, bool),
    ) -> Result<Option<Self>, StabilityError> {
        if !modes.is_frozen_map_unique() {
            return Ok(None);
        }
        // The states of an unstable loop cannot be scaled.
        let Ok(scales) = Scales::new(modes).map(|scales| scales.of_single_states()) else { return Ok(None) };
        let Some(event) = Event::new(modes, phases, &scales) else { return Ok(None) };
        let weights: Vec<f64> = (1..=phases.blend).map(|tick| cross_fade(tick as f64 / phases.blend as f64)).collect();
        let Some(responses) = Responses::new(modes, &scales, weights)? else { return Ok(None) };
        Ok(Proof { modes, phases, scales, event, responses }.shortest(longest, wants_reach))
    }
}

/// The effect of the states at an alarm on those at the end of the freeze.
struct Event {
    /// Bounds of the entries of the maps from an alarm to the release, over all lengths of the freeze: from `(x, r, φ,
    /// …)` to `(x, φ, g)`. The column of `r` excludes `e`.
    left: DMatrix<f64>,
    /// The entry from the reference to the gap.
    gap_of_reference: f64,
    /// `e`.
    along: Vec<f64>,
    /// The rows of the slave's position and of the feedback force at each frozen tick.
    frozen: [Vec<Vec<f64>>; 2],
    lengths: u64,
}

fn scaled(modes: &Modes, scales: &Scales, map: &DMatrix<f64>, spaces: (Space, Space)) -> Enclosure {
    scales.scaled(modes, &modes.between(map, spaces.0, spaces.1), spaces)
}

impl Event {
    fn new(modes: &Modes, phases: Phases, scales: &Scales) -> Option<Self> {
        let (n, whole) = (modes.states(), Space::Frozen);
        let frozen = scaled(modes, scales, &modes.frozen(0, 1.0), (whole, whole));
        let one = power(&frozen, 0);
        let powers = Powers::new(&frozen, (0, phases.held.1), &one);
        let vertices = if modes.has_unique_motion() { 0..1 } else { modes.vertices() };
        let releases: Vec<Enclosure> =
            vertices.map(|vertex| scaled(modes, scales, &modes.release(vertex), (whole, Space::FadingGap))).collect();
        let along: Vec<f64> = {
            let last = middle(&product(&releases[0], &powers.get(phases.held.1)));
            (0..n).map(|i| last[(i, n)]).collect()
        };
        let mut left = DMatrix::zeros(n + 2, frozen.len());
        let mut gap_of_reference: f64 = 0.0;
        let rows = [modes.slave(), modes.fed_back()]
            .map(|row| scales.scaled(modes, &modes.row(&row, whole), (whole, Space::Number)));
        let mut of_frozen = [vec![], vec![]];
        for ticks in 0..=phases.held.1 {
            interrupt::check();
            let map = powers.get(ticks);
            for (row, all) in rows.iter().zip(&mut of_frozen) {
                all.push(product(row, &map)[0].iter().map(|entry| magnitude(*entry)).collect());
            }
            if ticks < phases.held.0 {
                continue;
            }
            for (i, row) in releases.iter().flat_map(|release| product(release, &map).into_iter().enumerate()) {
                for (j, &entry) in row.iter().enumerate() {
                    let is_reference = j == n;
                    let rest = if is_reference && i < n { entry - Interval::exact(along[i]) } else { entry };
                    if is_reference && i == n + 1 {
                        gap_of_reference = gap_of_reference.max(magnitude(entry));
                    } else {
                        left[(i, j)] = f64::max(left[(i, j)], magnitude(rest));
                    }
                }
            }
        }
        let is_finite = left.iter().all(|value: &f64| value.is_finite()) && gap_of_reference.is_finite();
        let lengths = phases.held.1 - phases.held.0 + 1;
        is_finite.then_some(Self { left, gap_of_reference, along, frozen: of_frozen, lengths })
    }

    /// Bounds at the release for states at an alarm within `at_alarm`: of the loop's states and the force without `e
    /// g`, and of the gap without the reference.
    fn left_of(&self, at_alarm: &[f64]) -> Vec<f64> {
        let sum = |i: usize| at_alarm.iter().enumerate().map(|(j, bound)| self.left[(i, j)] * bound).sum::<f64>();
        (0..self.left.nrows()).map(|i| sum(i) * (1.0 + ROUNDING)).collect()
    }

    fn largest_frozen(&self, at_alarm: &[f64]) -> [f64; 2] {
        let row = |row: &Vec<f64>| row.iter().zip(at_alarm).map(|(entry, bound)| entry * bound).sum::<f64>();
        self.frozen.each_ref().map(|rows| rows.iter().map(row).fold(0.0, f64::max) * (1.0 + ROUNDING))
    }
}

struct Proof<'a> {
    modes: &'a Modes,
    phases: Phases,
    scales: Scales,
    event: Event,
    responses: Responses,
}

impl Proof<'_> {
    fn at_alarm(&self, track: &Track, gap: f64) -> Vec<f64> {
        let n = self.modes.states();
        let states: Vec<f64> = track.states.iter().copied().chain([gap]).collect();
        let mut all: Vec<f64> = vec![0.0; self.modes.size(Space::Frozen)];
        for vertex in self.modes.vertices() {
            let entry = self.modes.freeze() * self.modes.teleoperation(vertex);
            let entry = scaled(self.modes, &self.scales, &entry, (Space::LoopGap, Space::Frozen));
            for (bound, row) in all.iter_mut().zip(&entry) {
                let sum = row.iter().zip(&states).map(|(entry, state)| magnitude(*entry) * state).sum::<f64>();
                *bound = bound.max(sum * (1.0 + ROUNDING));
            }
        }
        // The bounds at the next tick also hold for the loop's states; slave, reference and force have their own.
        all[..n].copy_from_slice(&track.states);
        let slave = self.modes.master_states();
        let metre = self.scales.of(self.modes, Space::Loop)[(slave, slave)];
        all[slave] = all[slave].min(track.slave / metre * (1.0 + ROUNDING));
        all[n] = track.reference.iter().copied().fold(0.0, f64::max);
        for force in &mut all[n + 1..] {
            *force = force.min(track.force_n * self.newton() * (1.0 + ROUNDING));
        }
        all
    }

    fn start(&self, rest: &[f64]) -> Start {
        let n = self.modes.states();
        let mut state = self.event.along.clone();
        // The scaled gap and the scaled reference have the same unit.
        state.push(1.0);
        let state = state.into_iter().map(Interval::exact).collect();
        let force = rest[n] / self.newton();
        Start { state, rest: rest[..n].to_vec(), fades_from_n: Some(force * (1.0 + ROUNDING)) }
    }

    fn newton(&self) -> f64 {
        1.0 / self.scales.of(self.modes, Space::Fading)[(self.modes.states(), self.modes.states())]
    }

    fn shortest(&self, longest: u64, wants_reach: bool) -> Option<KeptGap> {
        let n = self.modes.states();
        let without = self.responses.track(&self.start(&vec![0.0; n + 1]))?;
        let rest: Vec<f64> =
            self.event.left_of(&self.at_alarm(&without, 1.0))[..=n].iter().map(|left| ROOM * left).collect();
        let track = self.responses.track(&self.start(&rest))?;
        let at_alarm = self.at_alarm(&track, 1.0);
        let left = self.event.left_of(&at_alarm);
        let mut of_rest: f64 = 0.0;
        for (left, rest) in left[..=n].iter().zip(&rest) {
            if *left > 0.0 {
                of_rest = of_rest.max(left / rest);
            }
        }
        // The alarm is at the tick after the dwell.
        let blend = self.phases.blend as usize;
        let mut growth: Vec<f64> = (track.reference[blend..].iter())
            .map(|reference| (reference * self.event.gap_of_reference + left[n + 1]) * (1.0 + ROUNDING))
            .collect();
        for at in (0..growth.len() - 1).rev() {
            growth[at] = growth[at].max(growth[at + 1]);
        }
        for bound in &mut growth {
            *bound = bound.max(of_rest);
        }
        let dwell_ticks = growth.iter().position(|bound| *bound <= MAX_GROWTH)? as u64 + 1;
        if dwell_ticks > longest {
            return None;
        }
        let (ticks, lengths) = (self.responses.ticks() as u64, self.event.lengths);
        let (spaces, maps) = self.spaces_and_maps();
        Some(KeptGap {
            dwell_ticks,
            conditions: ticks + lengths * (n as u64 + 2),
            reach: wants_reach.then(|| self.reach(&track, &at_alarm, &rest)).flatten(),
            growth,
            along: self.event.along.clone(),
            rest,
            ticks,
            spaces,
            maps,
        })
    }

    fn reach(&self, cycle: &Track, at_alarm: &[f64], rest: &[f64]) -> Option<(f64, f64)> {
        let n = self.modes.states();
        let later = self.largest(cycle, at_alarm, rest[n] / self.newton());
        let starts = self.modes.vertices().map(|vertex| {
            let state = self.modes.after_step(vertex);
            let state = self.modes.row(&DMatrix::from_row_slice(1, state.len(), state.as_slice()), Space::LoopGap);
            self.scales.scaled(self.modes, &state.transpose(), (Space::Number, Space::LoopGap))
        });
        let state = starts.reduce(|a, b| a.iter().zip(&b).map(|(a, b)| vec![a[0].with(b[0])]).collect())?;
        let state = state.into_iter().map(|row| row[0]).collect();
        let first = self.responses.track(&Start { state, rest: vec![0.0; n], fades_from_n: None })?;
        let first_alarm = self.at_alarm(&first, 0.0);
        let left = self.event.left_of(&first_alarm);
        let gap = first_alarm[n] * self.event.gap_of_reference + left[n + 1];
        let within = left[..=n].iter().zip(rest).filter(|(left, _)| **left > 0.0).map(|(left, rest)| left / rest);
        let size = within.fold(gap, f64::max) * (1.0 + ROUNDING);
        let before = self.largest(&first, &first_alarm, 0.0);
        Some((before[0].max(size * later[0]), before[1].max(size * later[1])))
    }

    fn largest(&self, track: &Track, at_alarm: &[f64], faded_n: f64) -> [f64; 2] {
        let [slave, force] = self.event.largest_frozen(at_alarm);
        [slave.max(track.slave), force.max(track.force_n.max(faded_n))]
    }

    fn spaces_and_maps(&self) -> (Vec<StateSpace>, Vec<StateMap>) {
        const SPACES: [Space; 4] = [Space::LoopGap, Space::Frozen, Space::FadingGap, Space::Number];
        let modes = self.modes;
        let spaces = SPACES.iter().map(|&space| StateSpace {
            name: format!("{space:?}"),
            states: modes.names(space),
            scale: self.scales.of(modes, space),
        });
        let place = |space: Space| SPACES.iter().position(|known| *known == space).unwrap_or(0);
        let mut maps = vec![];
        let mut add = |name: String, (from, to): (Space, Space), matrix: DMatrix<f64>| {
            maps.push(StateMap { name, from: place(from), to: place(to), matrix });
        };
        let (with_gap, frozen) = (Space::LoopGap, Space::Frozen);
        let row = |row: DMatrix<f64>| modes.row(&row, with_gap);
        for vertex in modes.vertices() {
            let teleoperation = modes.teleoperation(vertex);
            let mut tick = |name: &str, map: &DMatrix<f64>, spaces: (Space, Space)| {
                add(format!("{name}_{vertex}"), spaces, modes.between(map, spaces.0, spaces.1));
            };
            tick("teleoperation", &teleoperation, (with_gap, with_gap));
            tick("alarm", &(modes.freeze() * &teleoperation), (with_gap, frozen));
            tick("release", &modes.release(vertex), (frozen, Space::FadingGap));
            add(format!("force_{vertex}"), (with_gap, Space::Number), row(modes.force(vertex)));
            add(format!("hand_{vertex}"), (with_gap, Space::Number), row(modes.hand(vertex)));
        }
        add("frozen".into(), (frozen, frozen), modes.between(&modes.frozen(0, 1.0), frozen, frozen));
        for (name, column) in [("of_force", modes.of_force()), ("of_reference", modes.of_reference())] {
            add(name.into(), (Space::Number, with_gap), row(column.transpose()).transpose());
        }
        (spaces.collect(), maps)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::SwitchingSettings;
    use super::*;
    use crate::{LinearLoop, TissueRange};
    use trocar_scenario::{Scenario, Source};

    const TISSUE: (f64, f64) = (50.0, 600.0);

    fn proof(settings: &[&str]) -> (Modes, Phases, Option<KeptGap>) {
        let clutch = ["augmentation.reengage=clutch"];
        let settings: Vec<String> = clutch.iter().chain(settings).map(|&setting| setting.to_owned()).collect();
        let scenario = Scenario::load(&Source::parse("builtin:paper/augmented.toml"), &settings).expect("loads");
        let of_loop = LinearLoop::of(&scenario, TissueRange::spring(200.0, 5.0)).expect("analysed");
        let settings = SwitchingSettings::of(&scenario, of_loop, TISSUE).expect("covered");
        let modes = Modes::new(&settings).expect("built");
        let found = KeptGap::of(&modes, settings.phases(), (settings.longest_dwell_ticks(), true)).expect("computed");
        (modes, settings.phases(), found)
    }

    /// The gap before the next event, per metre of the gap before this event, with a tissue chosen at each
    /// tick.
    fn next_gap(modes: &Modes, phases: Phases, state: &mut DMatrix<f64>, mut choose: impl FnMut() -> (u64, u64, bool)) {
        let (held, dwell, _) = choose();
        let mut vertex = || usize::from(choose().2);
        *state = modes.freeze() * modes.teleoperation(vertex()) * &*state;
        for _ in 0..held {
            *state = modes.frozen(0, 1.0) * &*state;
        }
        *state = modes.release(vertex()) * &*state;
        for tick in 1..=phases.blend {
            let weight = cross_fade(tick as f64 / phases.blend as f64);
            *state = modes.blend(vertex(), weight) * &*state;
        }
        for _ in 1..dwell {
            *state = modes.teleoperation(vertex()) * &*state;
        }
    }

    #[test]
    fn the_certified_growth_is_close_to_the_growth_on_the_softest_tissue() {
        for settings in
            [&[][..], &["channel.delay_s=0.001"], &["channel.delay_s=0.005"], &["controller.kind=local-force"]]
        {
            let (_, phases, found) = proof(settings);
            let found = found.expect("certified");
            // The share of the gap that the springs of arm and tissue keep: 698.8 / (698.8 + 50).
            let growth = found.growth_after(phases.refractory);
            assert!((0.9332..0.945).contains(&growth), "{settings:?}: {growth}");
            assert!(found.growth_after(1) >= growth && found.dwell_ticks <= 5, "{settings:?}: {}", found.dwell_ticks);
        }
    }

    #[test]
    fn random_and_alternating_tissues_stay_within_the_bounds() {
        for settings in [&[][..], &["channel.delay_s=0.005"], &["controller.kind=local-force"]] {
            let (modes, phases, found) = proof(settings);
            let found = found.expect("certified");
            let mut random = ChaCha8Rng::seed_from_u64(24);
            let (gap, mut state) = (modes.states() + super::super::modes::GAP, DMatrix::zeros(modes.places_all(), 1));
            state[gap] = 1.0;
            for _ in 0..2000 {
                state = modes.teleoperation(0) * &state;
            }
            for event in 0..12 {
                // The tissue alternates with a random period for each event; with period 0 it is random at each tick.
                let (period, mut tick) = (random.random_range(0..200_u64), 0);
                let dwell = if event % 2 == 0 { phases.refractory } else { phases.refractory + 300 };
                next_gap(&modes, phases, &mut state, || {
                    tick += 1;
                    let is_stiff = if event % 3 == 0 { random.random() } else { tick / (period + 1) % 2 == 0 };
                    (if event % 2 == 0 { phases.held.0 } else { phases.held.1 }, dwell, is_stiff)
                });
                let before = state[gap];
                let mut next = state.clone();
                next_gap(&modes, phases, &mut next, || (phases.held.0, 1, true));
                let bound = found.growth_after(phases.refractory) * before.abs();
                assert!(next[gap].abs() <= bound, "{settings:?} {event}: {} {before}", next[gap]);
            }
            assert!(state[gap].abs() > 1e-6, "{settings:?}: nothing left to bound");
        }
    }

    #[test]
    fn a_growing_gap_has_no_proof() {
        // A force that remains while frozen holds the hand back, so the gap at the release exceeds the previous one.
        for setting in
            ["augmentation.decay_ratio=0.2", "augmentation.force_law=amplify", "controller.kind=position-position"]
        {
            assert!(proof(&[setting]).2.is_none(), "{setting}");
        }
    }
}
