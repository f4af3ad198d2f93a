//! Packets of a link: a master and a slave that greet each other, with packets of an attacker in between.

use std::sync::LazyLock;

use trocar_link::{Calling, Key, PACKET_BYTES, Waiting, fingerprint};
use trocar_scenario::{Scenario, Source};

static SCENARIO: LazyLock<[u8; 32]> = LazyLock::new(|| {
    fingerprint(&Scenario::load(&Source::parse("paper/augmented"), &[]).expect("a shipped scenario"))
});

pub fn packets(content: &[u8]) {
    let key = Key::of_loopback();
    let mut calling = Calling::new(key.clone(), [1; 16], *SCENARIO);
    let mut waiting = Waiting::new(key, [2; 16], *SCENARIO);
    let mut now_ns = 0;
    for (number, chunk) in content.chunks(PACKET_BYTES).enumerate() {
        now_ns += 1_000_000;
        // Either the attacker's bytes, or a genuine packet with the attacker's changes.
        let mut packet = if number % 2 == 0 { chunk.to_vec() } else { calling.hello(now_ns).to_vec() };
        if number % 2 == 1 {
            packet.iter_mut().zip(chunk).for_each(|(byte, change)| *byte ^= change);
        }
        if let Some(reply) = waiting.take(&packet, now_ns) {
            let _ = calling.take(&reply, now_ns);
        }
        let _ = calling.take(&packet, now_ns);
        if let Some(start) = calling.start(now_ns, now_ns + 1_000_000_000) {
            let _ = waiting.take(&start, now_ns);
        }
    }
    let _ = (calling.greeted(now_ns), waiting.greeted());
}
