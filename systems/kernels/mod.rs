//! The numbers: functions on values and slices. No world, no allocation, no threads.

pub mod bending;
pub mod bending_lanes;
pub mod bending_pack;
pub mod block;
pub mod block_pair;
pub mod disc;
pub mod factor_block;
pub mod failure;
pub mod fan;
pub mod flat_block;
pub mod flat_pack;
pub mod formulas;
pub mod gather;
pub mod lanes;
pub mod material_force;
pub mod membrane;
pub mod membrane_lanes;
pub mod pack;
pub mod path_work;
pub mod pick;
pub mod polar;
pub mod product_lanes;
pub mod separation;
pub mod simd;
