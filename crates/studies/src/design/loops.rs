//! Linear loops, computed once for the free keys on which they depend.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::quantity::Quantity;
use crate::stability_check::linear_loop;
use crate::sweep::{Axis, LoopOfCase};
use trocar_scenario::Scenario;
use trocar_stability::{LinearLoop, SwitchingSettings};

/// Sections of keys without effect on the linear loop.
const APART: [&str; 4] = ["augmentation.", "detector.", "estimator.", "perception."];

#[derive(Debug)]
pub(super) struct LoopFacts {
    linear: Option<LinearLoop>,
    is_stable: bool,
    /// `None` for quantities that are not of the loop.
    pub(super) values: Vec<Option<f64>>,
}

impl LoopFacts {
    /// True if no cheap condition excludes a certificate.
    pub(super) fn may_be_certified(&self, scenario: &Scenario) -> bool {
        let Some(linear) = self.linear.as_ref().filter(|_| self.is_stable) else {
            return false;
        };
        let events = SwitchingSettings::of(scenario, linear.clone(), linear.tissue.sector_n_per_m());
        events.is_ok_and(|events| !events.keeps_gap())
    }
}

type Key = (usize, Vec<u64>);

#[derive(Debug)]
pub(super) struct Loops {
    /// Indices of the free keys that affect the loop.
    keys: Vec<usize>,
    quantities: Vec<Quantity>,
    needs_margins: bool,
    known: Mutex<HashMap<Key, Arc<LoopFacts>>>,
}

impl Loops {
    pub(super) fn of(free: &[Axis], quantities: &[Quantity], is_certified: bool) -> Option<Self> {
        let needs_margins = quantities.iter().any(Quantity::is_of_loop);
        if !needs_margins && !is_certified {
            return None;
        }
        let acts = |path: &str| !APART.iter().any(|section| path.starts_with(section));
        let keys = (0..free.len()).filter(|&index| acts(&free[index].key.path)).collect();
        Some(Self { keys, quantities: quantities.to_vec(), needs_margins, known: Mutex::default() })
    }

    pub(super) fn facts(&self, operated: usize, coordinates: &[f64], scenario: &Scenario) -> Arc<LoopFacts> {
        let key = (operated, self.keys.iter().map(|&index| coordinates[index].to_bits()).collect());
        let known = |key: &Key| self.known.lock().unwrap_or_else(PoisonError::into_inner).get(key).cloned();
        if let Some(facts) = known(&key) {
            return facts;
        }
        let linear = linear_loop(scenario).ok();
        let is_stable = linear.as_ref().is_some_and(|linear| linear.in_range().is_ok_and(|verdict| verdict.is_stable));
        let values = if self.needs_margins {
            let of_case = LoopOfCase::new(scenario);
            self.quantities.iter().map(|quantity| quantity.of_loop(&of_case)).collect()
        } else {
            vec![None; self.quantities.len()]
        };
        let facts = Arc::new(LoopFacts { linear, is_stable, values });
        self.known.lock().unwrap_or_else(PoisonError::into_inner).insert(key, Arc::clone(&facts));
        facts
    }
}
