//! Three fixed persons, and groups in which each patient has another member.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use trocar_engine::operator::{Perception, PerceptionSettings};
use trocar_scenario::Scenario;
use trocar_scenario::population::{Arms, PeopleSettings, PopulationSettings, log_normal};

/// Separates these random numbers from others with the same seed.
const DOMAIN: u64 = 0x7065_6f70_6c65;

/// Everyone stops on noticing a drop of the force.
#[derive(Debug, Clone, Copy)]
pub struct Person {
    pub name: &'static str,
    pub meaning: &'static str,
    /// Sets the person's perception, or the group's medians.
    pub decide: fn(&mut PerceptionSettings),
    pub group: Option<Group>,
}

/// 68 % of the members lie within a factor of the median.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Group {
    /// Factor on the stiffness, damping and mass of the scenario's arm.
    pub arm: f64,
    pub arms: PeopleSettings,
    pub weber_spread: f64,
    pub criterion_spread: f64,
    pub reaction_spread: f64,
}

/// The spreads are a choice of this project.
const ADULTS: Group =
    Group { arm: 1.0, arms: PeopleSettings::DEFAULT, weber_spread: 1.3, criterion_spread: 1.2, reaction_spread: 1.15 };

pub(crate) const PERCEIVING: [&str; 2] = ["perception.reflex=stop", "perception.kind=psychometric"];

fn practise(of: &mut PerceptionSettings) {
    of.lapse_rate = 0.01;
    of.criterion = 2.0;
    of.reaction_mean_s = 0.16;
    of.reaction_std_s = 0.03;
}

/// Chosen here, in the directions of the sources: experienced surgeons detect contact sooner than novices (Zhou et al.,
/// Surg. Endosc. 22, 2008); children of 5 to 6 years do not discriminate grip forces by a constant Weber fraction
/// (Murase et al., Percept. Mot. Skills 82, 1996).
pub const PERSONS: [Person; 6] = [
    Person { name: "attentive", meaning: "The [perception] of the scenario.", decide: |_| {}, group: None },
    Person {
        name: "distracted",
        meaning: "One change in five goes unnoticed; a higher criterion and slower reactions.",
        decide: |of| {
            of.lapse_rate = 0.2;
            of.criterion = 3.5;
            of.reaction_mean_s = 0.35;
            of.reaction_std_s = 0.08;
        },
        group: None,
    },
    Person { name: "practised", meaning: "A lower criterion and faster reactions.", decide: practise, group: None },
    Person {
        name: "adult",
        meaning: "Adults: arms, grips and [perception] around those of the scenario.",
        decide: |_| {},
        group: Some(ADULTS),
    },
    Person {
        name: "child",
        meaning: "Children: half the arm, larger and more varied Weber fractions, more lapses, slower reactions.",
        decide: |of| {
            of.weber_fraction = 0.1;
            of.lapse_rate = 0.05;
            of.reaction_mean_s = 0.3;
            of.reaction_std_s = 0.06;
            of.reaction_min_s = 0.15;
        },
        group: Some(Group { arm: 0.5, weber_spread: 1.45, reaction_spread: 1.25, ..ADULTS }),
    },
    Person {
        name: "expert",
        meaning: "Experts: a lower criterion, fewer lapses, faster reactions.",
        decide: practise,
        group: Some(ADULTS),
    },
];

pub const FIXED_PERSONS: [&Person; 3] = [&PERSONS[0], &PERSONS[1], &PERSONS[2]];

impl Person {
    pub fn named(name: &str) -> Option<&'static Self> {
        PERSONS.iter().find(|person| person.name == name)
    }

    /// All groups draw the same random numbers.
    pub(crate) fn replace_operator(&self, scenario: &mut Scenario, patient: u64) {
        let Perception::Psychometric(perception) = &mut scenario.perception else { return };
        (self.decide)(perception);
        if let Some(group) = &self.group {
            let seed = scenario.seed ^ DOMAIN;
            let arms = PopulationSettings { arms: Arms::People(group.arms), ..PopulationSettings::DEFAULT };
            let arm = arms.drawn(seed, patient).arm.map(|factor| group.arm * factor);
            let of = &mut scenario.arm;
            let parts = [
                &mut of.k_a_n_per_m,
                &mut of.b_a_n_s_per_m,
                &mut of.k_h_n_per_m,
                &mut of.b_h_n_s_per_m,
                &mut of.m_h_kg,
            ];
            for (part, factor) in parts.into_iter().zip(arm) {
                *part *= factor;
            }
            let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 1);
            rng.set_stream(patient);
            perception.weber_fraction *= log_normal(group.weber_spread, rng.random());
            perception.criterion *= log_normal(group.criterion_spread, rng.random());
            perception.reaction_mean_s *= log_normal(group.reaction_spread, rng.random());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_base::quantiles::quantile_of;
    use trocar_scenario::Source;

    #[test]
    fn members_of_a_group_are_drawn_around_its_medians() {
        let base =
            Scenario::load(&Source::parse("layers/skin-augmented"), &PERCEIVING.map(str::to_owned)).expect("good");
        let person = Person::named("child").expect("a person");
        let group = person.group.expect("a group");
        let member = |patient: u64| {
            let mut scenario = base.clone();
            person.replace_operator(&mut scenario, patient);
            scenario
        };
        let of = |scenario: Scenario| (scenario.arm, scenario.perception);
        assert_eq!(of(member(3)), of(member(3)));
        let members: Vec<Scenario> = (0..2000).map(member).collect();
        let quantiles = |of: &dyn Fn(&Scenario) -> f64| {
            let mut values: Vec<f64> = members.iter().map(of).collect();
            [0.16, 0.5, 0.84].map(|share| quantile_of(&mut values, share).expect("values"))
        };
        let perception = |scenario: &Scenario| *scenario.perception.settings().expect("a decision");
        let [low, median, high] = quantiles(&|scenario| perception(scenario).weber_fraction);
        assert!((median / 0.1 - 1.0).abs() < 0.05, "{median}");
        assert!((high / median / group.weber_spread - 1.0).abs() < 0.05, "{high} {median}");
        assert!((median / low / group.weber_spread - 1.0).abs() < 0.05, "{low} {median}");
        let [.., mass_kg, _] = quantiles(&|scenario| scenario.arm.m_h_kg);
        assert!((mass_kg / base.arm.m_h_kg / group.arm - 1.0).abs() < 0.05, "{mass_kg}");
        // A single person is the same for every patient, and keeps the arm.
        let fixed = Person::named("distracted").expect("a person");
        let (mut one, mut two) = (base.clone(), base.clone());
        fixed.replace_operator(&mut one, 0);
        fixed.replace_operator(&mut two, 1);
        assert_eq!((one.arm, one.perception), (base.arm, two.perception));
    }
}
