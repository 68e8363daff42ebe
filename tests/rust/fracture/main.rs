//! Cracks, cuts, pieces and the states of broken bodies.

mod broken_states;
mod cracks;
mod cut;
mod pieces;
