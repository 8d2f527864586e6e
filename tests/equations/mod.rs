//! Simulators whose equations stand in the simulation file.

mod emps;
mod swing;
mod wrong;
