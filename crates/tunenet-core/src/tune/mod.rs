//! What fits: Algorithm 1, the fit through rollouts, intervals and verdicts.
