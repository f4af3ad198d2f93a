//! The tick, the machines between ticks, and the observers.

mod eight;
mod general;
mod general_master;
mod machines;
mod observers;
mod tick;
