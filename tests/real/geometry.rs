//! Columns of real points against double precision.

use crate::common::data;
use crate::common::xyz;

#[path = "../common/reference.rs"]
mod reference;

pub fn columns_are_those_of_double_precision() {
    for scan in data::KITTI.iter() {
        reference::assert_columns_agree(&scan.name, &xyz(&scan.points));
    }
}
