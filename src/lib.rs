//! trocar
