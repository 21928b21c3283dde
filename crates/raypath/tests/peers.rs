//! Bugs known from other designs, and the tests that would detect them here. The sources are the public records of
//! those projects, except where the table says otherwise. "Mutation" names a change in the code that makes the test
//! fail.
//!
//! | bug | source | tests |
//! | --- | --- | --- |
//! | state changed without a handshake: sums went on while invalid, while stalled, and across a reset | the original datapath (its four accumulator faults) | `semantics/original_faults.rs` (`fault_1_…` to `fault_4_…`), `semantics/accumulators.rs` (`other_jobs_bubbles_and_stalls_never_touch_a_sum`) |
//! | a direction of −0 taken for +0 | the original (it tests `dir >= 0`, which holds for −0) | `semantics/rule_1_direction.rs` (`minus_zero_swaps_so_that_a_box_around_the_origin_is_hit`) |
//! | flat boxes missed | the original's `tmin < tmax`; jspatial, issue 7 (a ray in a box's face) | `semantics/rule_4_touching.rs` (`flat_boxes_are_hit`), `semantics/rule_2_slab_nan.rs` (`a_flat_box_is_hit_by_a_ray_in_its_plane`) |
//! | 0·∞ in slabs: a ray in a face's plane hits or misses by chance | Embree, pull request 589; bvh (Rust), issue 140; ArborX, pull request 1226 | `semantics/rule_2_slab_nan.rs` (`all_six_distances_nan_by_zero_times_infinity`, `each_nan_is_ignored_alone_and_with_others`) |
//! | a NaN that is a hit | the original's triangle test | `semantics/rule_6_triangle_hit.rs` (`a_nan_among_the_edges_misses_but_hits_in_the_original`, `a_nan_t_num_misses_but_hits_in_the_original`) |
//! | the sign of a sum or product that is zero | BlackParrot, pull request 1161; RSD, issue 92; libm (Rust), pull request 493 | zeros, cancellations and products that underflow in `raypath verify testfloat`; all operands in `unit-proofs` |
//! | leading zeros of subnormals miscounted | Hercules, issue 29 (SoftFloat's normalisation, a count below zero) | [`every_subnormal`] |
//! | an unusual number of lanes: 1, or not a power of two, or more than tested | Spatz, pull request 86 (reductions over 8 lanes) | [`lane_counts`] |
//! | another latency in the model than in the hardware | without a published source | [`latency`]; for every pair of values the item `configurations` |

mod every_subnormal;
mod lane_counts;
mod latency;
