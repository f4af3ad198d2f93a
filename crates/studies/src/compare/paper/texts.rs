const GENERATED: &str =
    "The paper's recording was never published; a generator makes one from the facts that the paper states.";

pub(super) fn texts(figure: Option<u8>) -> [&'static str; 3] {
    match figure {
        Some(1) => [
            "The three phases of an insertion: the needle deforms the tissue, penetrates it, and is extracted.",
            "The three phases of the simulated tissue, as a sketch that is not to scale.",
            "Nothing is computed for it.",
        ],
        Some(4) => [
            "Measured and estimated force, and the absolute error of the estimate, for direct access to a liver.",
            "The same signals of a simulated insertion through capsule and organ, in the paper's sign, shifted in time \
             so that the puncture is at 4.6 s.",
            "A simulated tissue instead of a pig: the insertion is faster, and has one puncture and no small vessels.",
        ],
        Some(5) => [
            "Estimated stiffness and damping of the same insertion.",
            "The same estimates, and below them the two parts of the estimated force, -K p and -B v.",
            "The tissue is simulated, so its stiffness and damping differ from those of the liver.",
        ],
        Some(6) => [
            "Measured and estimated force, and the absolute error, for an insertion through the skin.",
            "The same signals of the in-vivo-like recording, in the paper's sign.",
            GENERATED,
        ],
        Some(7) => [
            "Estimated stiffness and damping of the insertion through the skin.",
            "The same estimates of the in-vivo-like recording, and below them the two parts of the estimated force, -K \
             p and -B v.",
            "The generator knows loads and drops, not the animal's parameters: their values differ.",
        ],
        Some(8) => [
            "The force of the insertion that is used for the detection: two ruptures, and a fast extraction, which is \
             not a rupture.",
            "The force of the in-vivo-like recording with its ruptures, in the paper's sign.",
            GENERATED,
        ],
        Some(9) => [
            "The squared change of the force from sample to sample, with added noise of 6.25e-4 N².",
            "The same quantity of the in-vivo-like recording with the same noise.",
            GENERATED,
        ],
        Some(10) => [
            "The principle: the error of the estimated force is the residual, from which the detector decides.",
            "The chain that every run computes.",
            "Residual, squared distance, CUSUM and threshold are the paper's; arming, cap and reset are added.",
        ],
        Some(11) => [
            "The distribution of the prediction error without ruptures, and a Gaussian of variance 4e-4 N².",
            "The prediction error during insertion, without the 0.5 s after each rupture, in the paper's sign.",
            "The errors of three stretches between ruptures are put together.",
        ],
        Some(12) => [
            "The squared prediction error with the noise of figure 9.",
            "The same distance of the in-vivo-like recording with that noise.",
            GENERATED,
        ],
        Some(13) => [
            "The decision function, and the force with the detected ruptures.",
            "The same, of the in-vivo-like recording, with the paper's drift and threshold, in the paper's sign.",
            "The decision function is capped, and reset at an alarm.",
        ],
        Some(14) => [
            "The block diagram of the modified force-position controller; the transient adaptation is bold.",
            "The same diagram of the simulated loop; the adaptation is in the colour of the augmented runs.",
            "Nothing is computed for it.",
        ],
        Some(15) => [
            "Forces and positions of master and slave around the first rupture, by classical teleoperation.",
            "The same signals of the classical run, in the paper's sign.",
            "The window in time is chosen here.",
        ],
        Some(16) => [
            "The same with augmentation: the slave is frozen for about 0.5 s while the master moves on.",
            "The same signals of the augmented run, with the time that the slave is frozen and re-engaging, in the \
             paper's sign.",
            "The paper does not say how the slave returns to the master; here a ramp re-engages it.",
        ],
        _ => [
            "Statements of sections 2, 3.1 and of the appendix that no figure shows.",
            "No figure.",
            "Figures 2 and 3 are photographs.",
        ],
    }
}
