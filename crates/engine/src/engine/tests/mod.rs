//! The tick, the machines between ticks, and the observers.

mod eight;
mod machines;
mod observers;
mod runs;
mod tick;
