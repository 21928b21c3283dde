//! Operations beside the paper's, a file each. A datapath has only those that are added to it.

pub mod key_compare;
pub mod octbox;
pub mod point_in_box;
pub mod quantised_box;
pub mod sphere;
