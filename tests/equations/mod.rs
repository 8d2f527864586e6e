//! Simulators whose equations stand in the simulation file.

mod delay;
mod emps;
mod law;
mod motor;
mod orbits;
mod swing;
mod wrong;
