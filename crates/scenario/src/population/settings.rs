//! The drawn quantities of a population, and their distributions.

use trocar_core::settings::Range;

const FACTOR: Range = Range::stated(0.01, 100.0, "from 0.01 to 100");

const SPREAD: Range = Range::stated(1.0, 10.0, "from 1 to 10");

const DELAY: Range = Range::stated(0.0, 2.0, "from 0 to 2 s");

trocar_core::settings! {
    /// A population around a scenario.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct PopulationSettings in "population." {
        /// Number of loops drawn at random, if anything is drawn.
        size: u64 [1..] = 200,
        /// The arms.
        arms: Arms,
        /// The tissues.
        tissues: Tissues,
        /// The delays.
        delays: Delays,
    }
}

trocar_core::choice! {
    /// Drawn arms: none, or different people and grips, relative to the scenario's arm.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Arms at "population.arm" = None {
        /// Every member has the scenario's arm.
        "none" => None,
        /// Different people and grips.
        "people" => People(PeopleSettings),
    }
}

trocar_core::settings! {
    /// People and their grips.
    ///
    /// A grip multiplies both stiffnesses of the arm, and both dampings by its root, which keeps the damping ratios.
    /// Stiffness and damping are known to rise with the grip (Hasser and Cutkosky 2002) and to differ between people
    /// (Fu and Çavuşoğlu 2012). The ranges are our choice; the grip has the range of `arm.grip`.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct PeopleSettings in "population." {
        /// Factor of the softest grip on both stiffnesses of the arm; its square root applies to both dampings. Grips
        /// are drawn uniformly in the logarithm.
        grip_min: f64 [self::FACTOR] = 0.5,
        /// Factor of the firmest grip.
        grip_max: f64 [self::FACTOR] = 2.0,
        /// Largest factor, up or down, by which each of the arm's five parameters differs between people, in addition
        /// to the grip. Drawn uniformly in the logarithm.
        person_spread: f64 [self::SPREAD] = 1.3,
    }
    where grip_max: |s| s.grip_max >= s.grip_min, "at least population.grip_min";
}

trocar_core::choice! {
    /// Drawn tissues: none, or log-normal distributions around the scenario's tissue.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Tissues at "population.tissue" = None {
        /// Every member has the scenario's tissue.
        "none" => None,
        /// Log-normal stiffness and damping.
        "log-normal" => LogNormal(TissueSpread),
    }
}

trocar_core::settings! {
    /// Log-normal distributions of stiffness and damping, truncated at three standard deviations.
    ///
    /// The shear modulus of healthy livers is 1.8 ± 0.4 kPa (Palmeri et al. 2008): 68 % of a log-normal distribution
    /// with this mean and standard deviation lie within a factor of 1.25. The damping is assumed to have the same
    /// distribution.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct TissueSpread in "population." {
        /// Factor around the scenario's stiffness within which 68 % of the tissue stiffnesses lie.
        stiffness_spread: f64 [self::SPREAD] = 1.25,
        /// Factor around the scenario's damping within which 68 % of the tissue dampings lie.
        damping_spread: f64 [self::SPREAD] = 1.25,
    }
}

trocar_core::choice! {
    /// Drawn delays: none, or a range.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Delays at "population.delay" = None {
        /// Every member has the scenario's delays.
        "none" => None,
        /// Uniform between two limits.
        "uniform" => Uniform(DelayRange),
    }
}

trocar_core::settings! {
    /// A range of constant delays, the same in both directions.
    ///
    /// Across the Atlantic the network took about 80 ms for both directions together (Marescaux et al. 2001).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DelayRange in "population." {
        /// Smallest delay in each direction.
        delay_min_s: f64 [self::DELAY] = 0.0,
        /// Largest delay in each direction. The drawn delay is the same in both directions, and uniformly distributed.
        delay_max_s: f64 [self::DELAY] = 0.04,
    }
    where delay_max_s: |s| s.delay_max_s >= s.delay_min_s, "at least population.delay_min_s";
}

impl PopulationSettings {
    pub fn varies(&self) -> bool {
        self.arms != Arms::None || self.tissues != Tissues::None || self.delays != Delays::None
    }
}
