//! Implicit steps: schemes in time, Newton's method, sparse systems. They know nodes and forces, not what made them.

mod krylov;
mod matrix;
mod newton;
mod scheme;

pub(crate) use krylov::conjugate_gradients;
pub(crate) use matrix::{Factor, Matrix};
pub(crate) use newton::{Balance, Failure, Residual, Rules, newton};
pub(crate) use scheme::{Scheme, Trial};
