//! Errors of linear systems, with the number and the remedy.

/// An error of a computation with linear systems. The message has the number and the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Two sizes that must agree do not.
    #[error("{what} is {found}, must be {expected}")]
    DimensionMismatch {
        /// Description of the size.
        what: &'static str,
        /// The size required by the other operands.
        expected: usize,
        /// The given size.
        found: usize,
    },
    /// An index points past the end.
    #[error("{what} {index} does not exist: there are {count}, counted from 0")]
    IndexOutOfRange {
        /// The kind of the index.
        what: &'static str,
        /// The given index.
        index: usize,
        /// The number of elements.
        count: usize,
    },
    /// A coefficient, matrix entry or frequency is infinite or not a number.
    #[error("{what} holds {value} at position {position}; every value must be finite")]
    NonFinite {
        /// Description of the array.
        what: &'static str,
        /// The invalid value.
        value: f64,
        /// Its position (column by column for a matrix).
        position: usize,
    },
    /// The denominator is the zero polynomial.
    #[error("the denominator is zero; give it at least one coefficient that is not 0")]
    ZeroDenominator,
    /// The denominator's first coefficient is 0, which is more likely a mistake than a lower order.
    #[error("the denominator's leading coefficient (of s^{degree}) is 0; leave it out if the order is lower")]
    ZeroLeadingDenominator {
        /// The power of s.
        degree: usize,
    },
    /// The zero transfer function has no inverse.
    #[error("a transfer function that is 0 everywhere has no inverse")]
    ZeroTransferFunction,
    /// The zero polynomial vanishes everywhere.
    #[error("the zero polynomial has every number as a root")]
    ZeroPolynomial,
    /// The function has more zeros than poles, so it has no state-space realisation.
    #[error(
        "the transfer function is improper (numerator of degree {numerator_degree} over denominator of degree \
         {denominator_degree}); close the loop around it, or multiply it by a lag, before realising it"
    )]
    Improper {
        /// Degree of the numerator.
        numerator_degree: usize,
        /// Degree of the denominator.
        denominator_degree: usize,
    },
    /// The derivative of the output would depend on the derivative of the input.
    #[error("the relative degree is {found}, must be at least {needed} for the output's derivative to be an output")]
    RelativeDegreeTooLow {
        /// The smallest sufficient relative degree.
        needed: i64,
        /// The relative degree.
        found: i64,
    },
    /// The tick is not positive and finite.
    #[error("the tick is {tick_s} s, must be positive and finite")]
    TickNotPositive {
        /// The given tick in s.
        tick_s: f64,
    },
    /// The lag is negative or not finite.
    #[error("the lag is {lag_s} s, must be finite and at least 0")]
    LagNegative {
        /// The given lag in s.
        lag_s: f64,
    },
    /// Two discrete systems have different ticks.
    #[error("the ticks differ ({first_s} s and {second_s} s); bring both systems to the same tick first")]
    UnequalTicks {
        /// The first system's tick in s.
        first_s: f64,
        /// The second system's tick in s.
        second_s: f64,
    },
    /// Direct paths form a loop of gain 1, which has no solution.
    #[error(
        "algebraic loop: I - D K ({size} x {size}) is singular; put a state (a lag, a mass) in the loop or change its gain"
    )]
    AlgebraicLoop {
        /// Number of outputs in the loop.
        size: usize,
    },
    /// A matrix that must be inverted is singular to working precision.
    #[error("{what} ({size} x {size}) is singular to working precision")]
    Singular {
        /// Description of the matrix.
        what: &'static str,
        /// Number of rows.
        size: usize,
    },
    /// The outputs are not independent combinations of states alone.
    #[error("the {outputs} chosen outputs cannot be states: {reason}")]
    OutputsNotStates {
        /// Number of chosen outputs.
        outputs: usize,
        /// The reason.
        reason: &'static str,
    },
    /// The QR iteration did not converge.
    #[error(
        "the eigenvalues of a {size} x {size} matrix did not converge in {iterations} iterations; rescale its units"
    )]
    EigenvaluesDidNotConverge {
        /// Number of rows.
        size: usize,
        /// Maximum number of iterations.
        iterations: usize,
    },
    /// The response is infinite at this point.
    #[error("{re}{im:+}i is a pole: the response there is infinite")]
    AtPole {
        /// Real part of the point.
        re: f64,
        /// Imaginary part of the point.
        im: f64,
    },
    /// The exponential overflows.
    #[error("the exponential of a matrix of 1-norm {norm} is not finite; take a shorter tick")]
    ExponentialOverflow {
        /// The 1-norm of the matrix.
        norm: f64,
    },
    /// No real principal logarithm exists: an eigenvalue is 0 or on the negative real axis.
    #[error(
        "no continuous system has this zero-order hold: {re}{im:+}i is a pole on the closed negative real axis \
         (a pure delay, or an oscillation at the Nyquist frequency)"
    )]
    NoRealLogarithm {
        /// Real part of the eigenvalue.
        re: f64,
        /// Imaginary part of the eigenvalue.
        im: f64,
    },
    /// The exponential of the computed logarithm differs from the matrix.
    #[error(
        "the matrix logarithm is off by {residual} (relative); an eigenvalue is too close to the negative real axis or to 0"
    )]
    LogarithmInaccurate {
        /// Relative residual of exp(log(A)) compared with A.
        residual: f64,
    },
    /// The prewarping frequency is not between 0 and the Nyquist frequency.
    #[error(
        "the prewarping frequency is {rad_per_s} rad/s, must lie strictly between 0 and the Nyquist frequency, {nyquist_rad_per_s} rad/s"
    )]
    PrewarpOutOfRange {
        /// The given frequency in rad/s.
        rad_per_s: f64,
        /// π / tick in rad/s.
        nyquist_rad_per_s: f64,
    },
}
