//! Stimulus and oracle of each added operation.

pub mod key_compare;
pub mod octbox;
pub mod point_in_box;
pub mod quantised_box;
pub mod sphere;
