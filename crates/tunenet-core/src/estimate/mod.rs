//! What a fit is: nonlinear least squares with parameters that recordings share and nuisance parameters of each, and how sure
//! its answer is. [`tune`](crate::tune) and [`diagnose`](crate::diagnose) both stand on it.
//!
//! | file | textbook name |
//! |---|---|
//! | `problem` | nonlinear least squares with shared and nuisance parameters |
//! | `jacobian` | forward differences, one-sided at a bound; by groups of columns |
//! | `derivatives` | Broyden's rank-one update |
//! | `huber` | M-estimate of regression |
//! | `normal_equations`, `block_arrow` | Gauss–Newton equations; bordered block-diagonal solve |
//! | `levenberg_marquardt` | Levenberg–Marquardt |
//! | `output_error` | output-error method: one simulator fitted to recordings |
//! | `rollout_log` | memoisation of rollouts |
//! | `noise_model` | noise of each channel |
//! | `interval`, `profile`, `region`, `contour` | profile likelihood |
//! | `contour_ray` | regula falsi with bisection |
//! | `matrix_rows` | serialisation of a matrix |
//! | `misfit_grid` | grid of profiled misfits |
//! | `information`, `cluster_robust` | Fisher information; cluster-robust covariance |
//! | `variance_components` | restricted likelihood of two variance components |
//! | `unread_states` | local observability of initial states |
//! | `separable_blocks`, `blockwise_search` | starts of a partially separable misfit, recombined and searched |
//! | `adequacy` | residual against noise |
//! | `projection`, `canonical_correlation` | Frisch–Waugh projection; correlation of two spans |
//! | `information_criterion` | Bayesian information criterion |

mod adequacy;
pub(crate) mod block_arrow;
pub(crate) mod blockwise_search;
pub(crate) mod canonical_correlation;
pub(crate) mod cluster_robust;
mod contour;
mod contour_ray;
mod derivatives;
pub(crate) mod huber;
mod information;
pub(crate) mod information_criterion;
mod interval;
pub(crate) mod jacobian;
pub(crate) mod levenberg_marquardt;
pub(crate) mod matrix_rows;
mod misfit_grid;
mod noise_model;
pub(crate) mod normal_equations;
mod output_error;
pub(crate) mod problem;
mod profile;
pub(crate) mod projection;
mod region;
mod rollout_log;
pub(crate) mod separable_blocks;
mod unread_states;
mod variance_components;

pub use adequacy::Adequacy;
pub(crate) use adequacy::is_below_step;
pub use contour::{Contour, contour};
pub use information::{Direction, Information};
pub use interval::{End, Interval, LEVEL, ScaleEstimate, ends};
pub(crate) use interval::{UNINFORMATIVE_SHARE, curved, ends_with};
pub(crate) use misfit_grid::{GridPoint, MisfitGrid};
pub use noise_model::channel_noise;
pub(crate) use noise_model::{floor, resolution, weights};
pub use output_error::{Fit, Linearisation, Problem, free};
pub(crate) use output_error::{GROWING_SHARES, residual_gap, weighted};
pub use problem::Point;
pub use profile::{Profile, profile};
pub use region::Region;
pub use rollout_log::{Phase, Request, RolloutLog, RolloutStore, Watch};
pub(crate) use unread_states::{STATE_STEP, unread_states};
