//! The step: constraints, forces, damping, momentum, plasticity, zones, rest; the same bits and saved states.

mod cells;
mod constraints;
mod control;
mod energy;
mod fields;
mod follow;
mod forces;
mod free_body;
mod goals;
mod hold_force;
mod inflation;
mod keyed;
mod links;
mod lowest_mode;
mod maps;
mod plasticity;
mod poisson;
mod quantities;
mod queries;
mod reset;
mod rest;
mod rigid;
mod same_bits;
mod saved_state;
mod selections;
mod zones;
