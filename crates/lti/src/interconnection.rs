use nalgebra::DMatrix;

use super::{Domain, Error, StateSpace, connect};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    /// From 0 across all appended systems.
    Output(usize),
    External(usize),
}

pub type WeightedSignals<'a> = &'a [(f64, Signal)];

/// Builds the static gains of [`connect`] around appended systems.
///
/// ```
/// # mod trocar { pub use trocar_lti as lti; }
/// use trocar::lti::{Signal, TransferFunction, Interconnection, realise};
///
/// // An integrator fed by 3 (r - y): the lag 3 / (s + 3).
/// let integrator = realise(&TransferFunction::new(&[1.0], &[1.0, 0.0])?)?;
/// let lag = Interconnection::new(&integrator, 1)
///     .feed(0, &[(3.0, Signal::External(0)), (-3.0, Signal::Output(0))])?
///     .read(&[(1.0, Signal::Output(0))])?
///     .close(&integrator)?;
/// assert_eq!(lag.poles()?[0].re, -3.0);
/// # Ok::<(), trocar::lti::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Interconnection {
    outputs: usize,
    externals: usize,
    gain: DMatrix<f64>,
    selection: Vec<Vec<f64>>,
}

impl Interconnection {
    pub fn new<D: Domain>(system: &StateSpace<D>, externals: usize) -> Self {
        let outputs = system.outputs();
        Self { outputs, externals, gain: DMatrix::zeros(system.inputs(), outputs + externals), selection: Vec::new() }
    }

    /// Adds `Σ weight · signal` to an input.
    pub fn feed(mut self, input: usize, sum: WeightedSignals) -> Result<Self, Error> {
        let count = self.gain.nrows();
        if input >= count {
            return Err(Error::IndexOutOfRange { what: "input", index: input, count });
        }
        for (weight, signal) in sum {
            let column = self.column(*signal)?;
            self.gain[(input, column)] += weight;
        }
        Ok(self)
    }

    pub fn read(mut self, sum: WeightedSignals) -> Result<Self, Error> {
        let mut row = vec![0.0; self.outputs + self.externals];
        for (weight, signal) in sum {
            row[self.column(*signal)?] += weight;
        }
        self.selection.push(row);
        Ok(self)
    }

    pub fn close<D: Domain>(&self, system: &StateSpace<D>) -> Result<StateSpace<D>, Error> {
        let columns = self.outputs + self.externals;
        let selection = DMatrix::from_fn(self.selection.len(), columns, |i, j| self.selection[i][j]);
        connect(system, &self.gain, &selection)
    }

    fn column(&self, signal: Signal) -> Result<usize, Error> {
        match signal {
            Signal::Output(index) if index >= self.outputs => {
                Err(Error::IndexOutOfRange { what: "output", index, count: self.outputs })
            }
            Signal::External(index) if index >= self.externals => {
                Err(Error::IndexOutOfRange { what: "external input", index, count: self.externals })
            }
            Signal::Output(index) => Ok(index),
            Signal::External(index) => Ok(self.outputs + index),
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;
    use crate::Continuous;

    #[test]
    fn connections_to_unknown_signals_are_rejected() {
        let gain = StateSpace::gain(dmatrix![1.0], Continuous).expect("finite");
        let wiring = Interconnection::new(&gain, 1);
        let nowhere = |what, index, count| Err(Error::IndexOutOfRange { what, index, count });
        assert_eq!(wiring.clone().feed(1, &[]), nowhere("input", 1, 1));
        assert_eq!(wiring.clone().feed(0, &[(1.0, Signal::Output(2))]), nowhere("output", 2, 1));
        assert_eq!(wiring.read(&[(1.0, Signal::External(1))]), nowhere("external input", 1, 1));
    }
}
