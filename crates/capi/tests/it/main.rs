//! The header, and programs in C and C++ that use it.

mod header;
mod programs;
