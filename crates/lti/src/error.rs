#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    #[error("{what} is {found}, must be {expected}")]
    DimensionMismatch {
        what: &'static str,
        /// Required by the other operands.
        expected: usize,
        found: usize,
    },
    #[error("{what} {index} does not exist: there are {count}, counted from 0")]
    IndexOutOfRange {
        what: &'static str,
        /// Counted from 0.
        index: usize,
        count: usize,
    },
    #[error("{what} holds {value} at position {position}; every value must be finite")]
    NonFinite {
        what: &'static str,
        value: f64,
        /// Column by column for a matrix.
        position: usize,
    },
    #[error("the denominator is zero; give it at least one coefficient that is not 0")]
    ZeroDenominator,
    /// More likely a mistake than a lower order.
    #[error("the denominator's leading coefficient (of s^{degree}) is 0; leave it out if the order is lower")]
    ZeroLeadingDenominator {
        /// Power of s.
        degree: usize,
    },
    #[error("a transfer function that is 0 everywhere has no inverse")]
    ZeroTransferFunction,
    #[error("the zero polynomial has every number as a root")]
    ZeroPolynomial,
    #[error(
        "the transfer function is improper (numerator of degree {numerator_degree} over denominator of degree \
         {denominator_degree}); close the loop around it, or multiply it by a lag, before realising it"
    )]
    Improper {
        /// Above `denominator_degree`.
        numerator_degree: usize,
        denominator_degree: usize,
    },
    #[error("the relative degree is {found}, must be at least {needed} for the output's derivative to be an output")]
    RelativeDegreeTooLow {
        /// Denominator degree minus numerator degree.
        needed: i64,
        found: i64,
    },
    #[error("the tick is {tick_s} s, must be positive and finite")]
    TickNotPositive {
        /// Zero, negative or not finite.
        tick_s: f64,
    },
    #[error("the lag is {lag_s} s, must be finite and at least 0")]
    LagNegative {
        /// Negative or not finite.
        lag_s: f64,
    },
    #[error("the ticks differ ({first_s} s and {second_s} s); bring both systems to the same tick first")]
    UnequalTicks {
        /// Of discrete systems.
        first_s: f64,
        second_s: f64,
    },
    #[error(
        "algebraic loop: I - D K ({size} x {size}) is singular; put a state (a lag, a mass) in the loop or change its gain"
    )]
    AlgebraicLoop {
        /// Outputs in the loop.
        size: usize,
    },
    #[error("{what} ({size} x {size}) is singular to working precision")]
    Singular {
        /// Of the matrix.
        what: &'static str,
        size: usize,
    },
    #[error("the {outputs} chosen outputs cannot be states: {reason}")]
    OutputsNotStates {
        /// Number of chosen outputs.
        outputs: usize,
        reason: &'static str,
    },
    #[error(
        "the eigenvalues of a {size} x {size} matrix did not converge in {iterations} iterations; rescale its units"
    )]
    EigenvaluesDidNotConverge {
        /// Of the matrix.
        size: usize,
        iterations: usize,
    },
    #[error("{re}{im:+}i is a pole: the response there is infinite")]
    AtPole {
        /// Of s or z.
        re: f64,
        im: f64,
    },
    #[error("the exponential of a matrix of 1-norm {norm} is not finite; take a shorter tick")]
    ExponentialOverflow {
        /// 1-norm of the matrix.
        norm: f64,
    },
    #[error(
        "no continuous system has this zero-order hold: {re}{im:+}i is a pole on the closed negative real axis \
         (a pure delay, or an oscillation at the Nyquist frequency)"
    )]
    NoRealLogarithm {
        /// Of an eigenvalue at 0 or on the negative real axis.
        re: f64,
        im: f64,
    },
    #[error(
        "the matrix logarithm is off by {residual} (relative); an eigenvalue is too close to the negative real axis or to 0"
    )]
    LogarithmInaccurate {
        /// `|exp(log A) - A| / |A|` in the 1-norm.
        residual: f64,
    },
    #[error(
        "the prewarping frequency is {rad_per_s} rad/s, must lie strictly between 0 and the Nyquist frequency, {nyquist_rad_per_s} rad/s"
    )]
    PrewarpOutOfRange {
        rad_per_s: f64,
        /// π / tick.
        nyquist_rad_per_s: f64,
    },
}
