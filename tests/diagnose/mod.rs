//! `diagnose` names what a simulation lacks, or what it cannot tell apart.

mod answers;
mod channels;
mod contacts_alone;
mod effects;
mod formulas;
mod gripping;
mod jets;
mod laws;
mod real;
mod shifted;
