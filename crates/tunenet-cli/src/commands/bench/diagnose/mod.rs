//! `tunenet bench diagnose`
mod blind;
