//! The volume-preserving correction: measures, fields, limits, scopes, the cubic equation.

mod contact;
mod cubic;
mod field;
mod global;
mod limits;
mod passes;
mod regional;
mod solid;
