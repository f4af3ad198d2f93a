//! What the tests of dead and restarted sides share.

use trocar_link::{Calling, Greeted, Key, Waiting, fingerprint};
use trocar_scenario::{Scenario, Source};

/// An insertion through skin of 5 s, with further settings.
pub fn scenario(settings: &[&str]) -> Scenario {
    let all: Vec<String> = ["simulation.duration_s=5.0"].iter().chain(settings).map(|&text| text.to_owned()).collect();
    Scenario::load(&Source::parse("builtin:layers/skin-augmented"), &all).expect("loads")
}

/// Greets two new sides.
pub fn greeted(scenario: &Scenario) -> (Greeted, Greeted) {
    let (key, scenario) = (Key::of_loopback(), fingerprint(scenario));
    let (mut master, mut slave) = (Calling::new(key.clone(), [1; 16], scenario), Waiting::new(key, [2; 16], scenario));
    master.take(&slave.take(&master.hello(0), 0).expect("a reply"), 0);
    master.take(&slave.take(&master.start(0, 0).expect("a slave"), 0).expect("ready"), 0);
    (master.greeted(0).expect("ready"), slave.greeted().expect("started").clone())
}
