//! Tests of the adaptive distance against its definition and on whole signals.

use super::*;
use crate::detector::fixtures::{Noise, QUIET, with_force};

/// Processes forces (N) and positions (m) `tick_s` apart. Returns the times (s) at which the distance exceeds 7.
fn alarms_s(tick_s: f64, end_s: f64, signal: impl Fn(f64) -> (f64, f64)) -> [Option<f64>; 3] {
    let mut adaptive = Adaptive::<f64>::new(&DistanceSettings::DEFAULT, tick_s);
    let mut found = [None; 3];
    let mut count = 0;
    for sample in 0..(end_s / tick_s) as usize {
        let time_s = sample as f64 * tick_s;
        let (force_n, depth_m) = signal(time_s);
        // A synthetic noise of 10 mN, the same at every rate.
        let noise_n = 0.02 * (libm::fmod(libm::fabs(libm::sin(12.9898 * sample as f64)) * 43_758.5, 1.0) - 0.5);
        let input = DetectorInput { force_n: force_n + noise_n, depth_m, ..QUIET };
        if adaptive.update(&input) > 7.0 {
            adaptive.reset(true);
            if count < found.len() {
                found[count] = Some(time_s);
                count += 1;
            }
        }
    }
    found
}

/// An insertion at 10 mm/s into 500 N/m that ruptures at 1 s, within `fall_s`.
fn insertion(fall_s: f64) -> impl Fn(f64) -> (f64, f64) {
    move |time_s| {
        let (load_n, depth_m) = (5.0 * time_s.min(1.0), 0.01 * time_s);
        (load_n - 3.0 * ((time_s - 1.0) / fall_s).clamp(0.0, 1.0), depth_m)
    }
}

#[test]
fn a_fall_raises_exactly_one_alarm_at_every_rate() {
    for rate_hz in [100.0, 333.0, 700.0, 1000.0, 2000.0, 10_000.0] {
        for fall_s in [1e-3, 10e-3, 50e-3] {
            let found = alarms_s(1.0 / rate_hz, 2.0, insertion(fall_s));
            let latest_s = 1.0 + fall_s + f64::max(0.010, 3.0 / rate_hz);
            let is_in_time = found[0].is_some_and(|time_s| (1.0..=latest_s).contains(&time_s));
            assert!(is_in_time && found[1].is_none(), "{rate_hz} Hz, {fall_s} s: {found:?}");
        }
    }
}

/// An insertion whose machine rings after the fall with a share of it, at a frequency (Hz), with a decay (s).
fn ringing(share: f64, frequency_hz: f64, decay_s: f64) -> impl Fn(f64) -> (f64, f64) {
    move |time_s| {
        let (force_n, depth_m) = insertion(1e-3)(time_s);
        let since_s = (time_s - 1.001).max(0.0);
        let phase = core::f64::consts::TAU * frequency_hz * since_s;
        (force_n - 3.0 * share * libm::exp(-since_s / decay_s) * libm::sin(phase), depth_m)
    }
}

#[test]
fn a_machine_that_rings_after_a_rupture_raises_no_further_alarm() {
    for rate_hz in [167.0, 500.0, 1000.0, 5000.0] {
        for frequency_hz in [5.0, 12.0, 27.0, 60.0, 150.0] {
            // At most a third of the Nyquist rate.
            let frequency_hz = f64::min(frequency_hz, rate_hz / 6.0);
            for (share, decay_s) in [(0.05, 0.5), (0.1, 0.2), (0.3, 0.05), (0.3, 0.5)] {
                let found = alarms_s(1.0 / rate_hz, 4.0, ringing(share, frequency_hz, decay_s));
                let is_one = found[0].is_some_and(|time_s| time_s < 1.03) && found[1].is_none();
                assert!(is_one, "{rate_hz} Hz, {share} at {frequency_hz} Hz for {decay_s} s: {found:?}");
            }
        }
    }
}

#[test]
fn a_second_layer_that_ruptures_50_ms_later_raises_an_alarm_with_and_without_a_ring_down() {
    for rate_hz in [333.0, 1000.0, 5000.0] {
        for share in [0.0, 0.1] {
            let ringing = ringing(share, 30.0, 0.1);
            let two_layers = |time_s: f64| {
                let (force_n, depth_m) = ringing(time_s);
                (force_n - if time_s > 1.05 { 1.5 } else { 0.0 }, depth_m)
            };
            let found = alarms_s(1.0 / rate_hz, 3.0, two_layers);
            assert!(found[1].is_some_and(|time_s| (1.05..1.07).contains(&time_s)), "{rate_hz} Hz, {share}: {found:?}");
            assert_eq!(found[2], None, "{rate_hz} Hz, {share}");
        }
    }
}

#[test]
fn an_offset_of_the_sensor_does_not_hide_a_rupture() {
    for offset_n in [-30.0, -12.0, -3.0, 0.0, 0.4, 7.0, 25.0] {
        let offset = |time_s: f64| {
            let (force_n, depth_m) = insertion(5e-3)(time_s);
            (force_n + offset_n, depth_m)
        };
        let found = alarms_s(1e-3, 2.0, offset);
        assert!(found[0].is_some_and(|time_s| (1.0..1.015).contains(&time_s)), "{offset_n} N: {found:?}");
        assert_eq!(found[1], None, "{offset_n} N");
    }
}

#[test]
fn a_restart_under_load_keeps_the_offset_of_the_sensor() {
    // A sensor with an offset of 20 N. Its load of 2 N falls by 1.7 N, which is less than a tenth of the force.
    let mut adaptive = Adaptive::<f64>::new(&DistanceSettings::DEFAULT, 1e-3);
    let mut noise = Noise(5);
    let mut largest = |adaptive: &mut Adaptive<f64>, force_n: f64, samples: u32| {
        let input = |noise_n: f64| with_force(force_n + 0.01 * noise_n);
        (0..samples).map(|_| adaptive.update(&input(noise.next()))).fold(0.0, f64::max)
    };
    largest(&mut adaptive, 20.0, 200);
    let mut restarted = adaptive.restarted(&DistanceSettings::DEFAULT, 1e-3);
    let mut anew = Adaptive::<f64>::new(&DistanceSettings::DEFAULT, 1e-3);
    let falls = [&mut restarted, &mut anew].map(|adaptive| {
        assert_eq!(largest(adaptive, 22.0, 200), 0.0);
        largest(adaptive, 20.3, 20) > THRESHOLD
    });
    assert_eq!(falls, [true, false], "a new detector takes the load for the offset");
}

#[test]
fn a_released_or_stopped_needle_is_not_a_rupture() {
    // A rigid stop of 20 kN/m, pressed with 5 N and released in 30 ms; an encoder of 50 µm.
    let let_go = |time_s: f64| {
        let force_n = 5.0 * (time_s / 0.5).min(1.0) - 5.0 * ((time_s - 1.0) / 0.03).clamp(0.0, 1.0);
        (force_n, libm::round(force_n / 20e3 / 50e-6) * 50e-6)
    };
    // A spring of 300 N/m and a damper of 20 N·s/m, pushed at 50 mm/s and stopped within 20 ms.
    let stopped = |time_s: f64| {
        let since_s = (time_s - 0.5).max(0.0);
        let slowed = libm::exp(-since_s / 0.02);
        let depth_m = 0.05 * time_s.min(0.5) + 0.05 * 0.02 * (1.0 - slowed);
        (300.0 * depth_m + 20.0 * 0.05 * slowed, depth_m)
    };
    for rate_hz in [333.0, 1000.0, 5000.0] {
        assert_eq!(alarms_s(1.0 / rate_hz, 2.0, let_go), [None; 3], "let go at {rate_hz} Hz");
        assert_eq!(alarms_s(1.0 / rate_hz, 2.0, stopped), [None; 3], "stopped at {rate_hz} Hz");
    }
}

#[test]
fn no_window_is_longer_than_the_bins() {
    for micros in 1..200_000 {
        let tick_s = 1e-6 * f64::from(micros);
        let Times { windows, reference, stiffness, .. } =
            Adaptive::<f64>::new(&DistanceSettings::DEFAULT, tick_s).times;
        assert!(windows[WINDOWS_S.len() - 1] + reference < BINS && stiffness < BINS, "{tick_s}");
    }
}

/// The definition in the doc comment, computed from the whole history of a signal without alarms, on bins of
/// `bin_s`. Before the first bin the force and the position have their first values, and the surplus is 0.
#[derive(Default)]
struct Definition {
    bin_s: f64,
    force: Vec<f64>,
    position: Vec<f64>,
    surplus: Vec<f64>,
    speed: Vec<f64>,
    scales: [f64; 5],
    squares: f64,
    products: f64,
    stiffest: f64,
    load: f64,
    unloaded: f64,
}

/// The value of a signal `ago` bins before its end, or its first value before its beginning.
fn ago(signal: &[f64], ago: usize) -> f64 {
    signal[signal.len().saturating_sub(1 + ago)]
}

/// The value of a signal `ago` bins before its end, or 0 before its beginning.
fn ago_or_0(signal: &[f64], ago: usize) -> f64 {
    if ago < signal.len() { signal[signal.len() - 1 - ago] } else { 0.0 }
}

impl Definition {
    fn bins(&self, time_s: f64) -> usize {
        ((time_s / self.bin_s).round() as usize).max(1)
    }

    fn moved(signal: &[f64], bins: usize) -> f64 {
        ago(signal, 0) - ago(signal, bins)
    }

    /// The distance at a bin, from the position of the next bin and the steps of encoder and sensor.
    fn update(&mut self, force: f64, position: f64, next_position: f64, steps: [f64; 2]) -> f64 {
        self.force.push(force);
        self.position.push(position);
        // The mean of the first 50 bins, then a share of what is below.
        let all = self.force.len();
        if all <= 50 {
            self.unloaded = self.force.iter().sum::<f64>() / all as f64;
        } else {
            let sunk = self.unloaded + (force - self.unloaded).min(0.0) * self.bin_s / 5.0;
            self.unloaded = sunk.max(self.unloaded.min(0.0));
        }
        let unloaded = self.unloaded;
        let clear = (0.05 * unloaded.abs()).max(6.0 * self.scales[0]);
        let size = |force: f64, before: f64| {
            if force.min(before) - unloaded >= clear { force - unloaded } else { force.abs() }
        };
        let [eight, reference, instant] = [8e-3, 15e-3, 4e-3].map(|time_s| self.bins(time_s));
        let is_loaded = ago(&self.force, eight) - unloaded > 6.0 * self.scales[0];
        if is_loaded {
            let (rise, advance) = (Self::moved(&self.force, eight), Self::moved(&self.position, eight));
            let share = self.bin_s / 0.3;
            self.squares += (advance * advance - self.squares) * share;
            self.products += (advance * rise - self.products) * share;
        }
        let stiffness = if self.squares > 0.0 { (self.products / self.squares).max(0.0) } else { 0.0 };
        let unexplained = Self::moved(&self.force, 1) - stiffness * Self::moved(&self.position, 1);
        self.surplus.push(ago_or_0(&self.surplus, 0) + unexplained);
        let per = |bins: usize| 1.0 / (bins as f64 * self.bin_s);
        let mean = Self::moved(&self.position, reference) * per(reference);
        self.speed.push(mean.max((Self::moved(&self.position, instant) - steps[0]) * per(instant)));

        let over = |signal: &[f64], from: usize, to: usize, more: fn(f64, f64) -> f64| {
            (from..=to).map(|bins| ago(signal, bins)).reduce(more).expect("a bin")
        };
        let surplus_over = |from: usize, to: usize| {
            (from..=to).map(|bins| ago_or_0(&self.surplus, bins)).reduce(f64::min).expect("a bin")
        };
        // Four references, which cover the longest window and the reference before it.
        let whole = 4 * reference - 1;
        let retreat = over(&self.position, 0, whole, f64::max) - position + steps[0];
        let released = stiffness.max(self.stiffest) * retreat;
        let velocity = (next_position - ago(&self.position, instant - 1)) * per(instant);
        let mut largest = 0.0_f64;
        for (index, window_s) in [2e-3, 4e-3, 8e-3, 16e-3, 32e-3].into_iter().enumerate() {
            let window = self.bins(window_s);
            if Self::moved(&self.position, window) < 0.0 {
                continue;
            }
            let at_start = ago(&self.force, window + reference);
            let peak = over(&self.force, window, window + reference - 1, f64::max);
            let speed = ago_or_0(&self.speed, window);
            let lost = ((speed - velocity) / speed.max(2e-3)).min(1.0);
            let (last, lowest) = (surplus_over(window, window + 1), surplus_over(window, window + reference - 1));
            let goes_through = lost < 0.1 && velocity > 5e-3 && last - lowest >= 0.1 * size(peak, at_start);
            let before = if goes_through { last } else { lowest };
            let falling = ago_or_0(&self.surplus, window + reference) - ago_or_0(&self.surplus, window);
            let continued = falling.max(0.0) * window as f64 / reference as f64;
            let fall = (before - ago(&self.surplus, 0) - continued).min(peak - force - released);
            let least = (0.1_f64.max(0.7 * lost) * size(peak, at_start)).max(0.05 * self.load);
            if fall > least {
                let scale = self.scales[index].max(0.5 * steps[1]).max(1e-9);
                largest = largest.max(fall.min(size(peak, at_start)) / scale);
            }
        }
        let is_at_rest = steps[0] < 1e-4 && Self::moved(&self.position, BINS - 1) <= 1e-9;
        let highest = over(&self.force, 0, whole, f64::max);
        let has_fallen = highest - force > 0.1 * (highest - unloaded).min(highest.abs());

        let count = self.force.len() as f64;
        let share = (1.0 / count).max((self.bin_s / 1.0).min(1.0));
        for (index, window_s) in [2e-3, 4e-3, 8e-3, 16e-3, 32e-3].into_iter().enumerate() {
            let window = self.bins(window_s).max(3);
            let rise = Self::moved(&self.force, window);
            let change = rise.abs().min((rise - stiffness * Self::moved(&self.position, window)).abs());
            let clipped = if count >= 50.0 { change.min(3.0 * self.scales[index]) } else { change };
            self.scales[index] += (clipped - self.scales[index]) * share;
        }
        if self.force.len() == 50 && self.unloaded.abs() < 20.0 * self.scales[0] {
            self.unloaded = 0.0;
        }
        self.load = (self.load * (-self.bin_s / 0.3).exp()).max(force - unloaded);
        let longest = self.bins(32e-3).max(3);
        let (rise, advance) = (Self::moved(&self.force, longest), Self::moved(&self.position, longest));
        let is_load = rise > 6.0 * self.scales[4] && advance >= -steps[0];
        let load = if is_load { rise / advance.max(steps[0]).max(1e-9) } else { 0.0 };
        self.stiffest = load.max(self.stiffest * (-self.bin_s / 5.0).exp());
        if count >= 50.0 && has_fallen && !is_at_rest { largest } else { 0.0 }
    }
}

/// Compares the distance with its definition. Returns the number of samples at which it is above 0.
fn compare(tick_s: f64, samples: usize, mut signal: impl FnMut(f64) -> (f64, f64)) -> usize {
    let mut adaptive = Adaptive::<f64>::new(&DistanceSettings::DEFAULT, tick_s);
    let in_bin = (1e-3 / tick_s - 1e-9).ceil().max(1.0) as usize;
    let mut definition = Definition { bin_s: in_bin as f64 * tick_s, ..Definition::default() };
    let (mut last, mut steps, mut bin) = (None::<[f64; 2]>, [1e-4, f64::MAX], vec![]);
    let (mut forces, mut positions): (Vec<f64>, Vec<f64>) = (vec![], vec![]);
    let (mut expected, mut above) = (0.0, 0);
    for sample in 0..samples {
        let (force, position) = signal(sample as f64 * tick_s);
        if let Some([x, f]) = last {
            for (step, (change, rounding)) in steps.iter_mut().zip([(position - x, 1e-9), (force - f, 1e-6)]) {
                let change: f64 = change;
                if change.abs() > rounding {
                    *step = step.min(change.abs());
                }
            }
        } else {
            (forces, positions) = (vec![force; 2], vec![position]);
        }
        last = Some([position, force]);
        bin.push((force, position));
        if bin.len() == in_bin {
            let share = 1.0 / in_bin as f64;
            forces.push(bin.iter().map(|sample| sample.0).sum::<f64>() * share);
            positions.push(bin.iter().map(|sample| sample.1).sum::<f64>() * share);
            bin.clear();
            let mut three = [ago(&forces, 0), ago(&forces, 1), ago(&forces, 2)];
            three.sort_by(f64::total_cmp);
            expected = definition.update(three[1], ago(&positions, 1), ago(&positions, 0), steps);
        }
        let input = DetectorInput { force_n: force, depth_m: position, ..QUIET };
        let distance = adaptive.update(&input);
        assert!(
            (distance - expected).abs() <= 1e-6 * expected.abs(),
            "{tick_s} s, sample {sample}: {distance} instead of {expected}"
        );
        above += usize::from(expected > 0.0);
    }
    above
}

/// An insertion with loads of several stiffnesses, falls of several lengths, impacts, stops, and retreats.
fn eventful(seed: u64, encoder_m: f64, noise_n: f64) -> impl FnMut(f64) -> (f64, f64) {
    let mut noise = Noise(seed);
    let (mut position, mut load, mut stiffness, mut speed, mut fall, mut phase) = (0.0, 0.5, 300.0, 0.01, 1.0, 0);
    let mut last_s = 0.0;
    move |time_s| {
        let passed_s = time_s - last_s;
        last_s = time_s;
        let next = (time_s / 0.1) as u32;
        if next != phase {
            phase = next;
            stiffness = 800.0 * (1.0 + noise.next());
            speed = [0.01, 0.03, 0.0, 0.012, -0.01, 0.02, 0.006][phase as usize % 7] * (1.0 + 0.2 * noise.next());
            fall = if phase % 2 == 0 { 0.1 + 0.6 * noise.next().abs() } else { 0.0 };
        }
        // In the first ten milliseconds of every other phase a share of the load is lost.
        if time_s - 0.1 * f64::from(phase) < 0.01 {
            load *= 1.0 - fall * (passed_s / 0.01).min(1.0);
        }
        position += speed * passed_s;
        load += stiffness * speed * passed_s;
        let spike = if phase % 5 == 3 && time_s - 0.1 * f64::from(phase) > 0.05 { 0.3 * load } else { 0.0 };
        let read_m = if encoder_m > 0.0 { (position / encoder_m).round() * encoder_m } else { position };
        (load + spike + 2.0 * speed + noise_n * noise.next(), read_m)
    }
}

#[test]
fn the_distance_follows_its_definition_at_every_sample() {
    for tick_s in [1e-3, 5e-4, 3e-4, 2e-3, 6e-3, 0.02] {
        let samples = (6.0 / tick_s) as usize;
        for (seed, encoder_m, noise_n) in [(1, 0.0, 0.01), (2, 2e-6, 0.02), (3, 2e-4, 0.005), (4, 0.0, 0.1)] {
            let above = compare(tick_s, samples, eventful(seed, encoder_m, noise_n));
            assert!(above > samples / 500, "falls are found: {above} at {tick_s} s, {seed}");
        }
    }
}

#[test]
fn a_force_that_does_not_change_is_stuck_after_a_fifth_of_a_second() {
    for tick_s in [1e-3, 5e-4] {
        let mut adaptive = Adaptive::<f64>::new(&DistanceSettings::DEFAULT, tick_s);
        let mut ready = |force_n| {
            adaptive.update(&with_force(force_n));
            adaptive.is_ready() == Some(true)
        };
        let per_bin = (1e-3 / tick_s).round() as u32;
        let known = (1..).find(|&sample| ready(f64::from(sample % 2)));
        assert_eq!(known, Some(50 * per_bin), "after 50 bins the scales are known");
        let stuck = (1..).find(|_| !ready(0.5));
        // A force that has just changed counts as changed until the end of its bin.
        assert!(stuck.is_some_and(|samples| (201 * per_bin..=202 * per_bin).contains(&samples)), "{stuck:?}");
        assert!(ready(1.0), "it has changed");
    }
}

#[test]
fn a_wanted_rate_scales_the_distance_by_the_threshold_over_its_level() {
    let rate = |false_alarms_per_min| {
        let rate = super::super::RateSettings { false_alarms_per_min };
        Adaptive::<f64>::new(&DistanceSettings { rate, ..DistanceSettings::DEFAULT }, 1e-3)
    };
    let (mut plain, mut rated) = (rate(None), rate(Some(0.1)));
    let mut signal = eventful(7, 0.0, 0.02);
    let mut above = 0;
    for sample in 0..3000 {
        let (force_n, depth_m) = signal(1e-3 * f64::from(sample));
        let input = DetectorInput { force_n, depth_m, ..QUIET };
        let level = rated.tail.as_ref().expect("a rate is wanted").level();
        let (value, relative) = (plain.update(&input), rated.update(&input));
        assert!((relative - value * THRESHOLD / level).abs() < 1e-9 * value.max(1.0), "{sample}");
        above += usize::from(value > 0.0);
    }
    assert!(above > 10, "{above}");
    let credit = rated.tail.as_ref().expect("a rate is wanted").sums();
    rated.reset(true);
    assert_ne!(rated.tail.as_ref().expect("a rate is wanted").sums(), credit, "an alarm counts in the tail");
    assert_eq!(rated.value, 0.0);
}
