//! Point files as their makers wrote them.

use flicr::files;
use pcd_rs::DynReader;

use crate::common::data;

pub fn point_files_are_read() {
    let expected = [
        ("hesai/pandar40p_dual.reference.pcd", 56_762, None),
        ("hesai/xt32_dual.reference.pcd", 63_021, None),
        ("kitti/drive/000000.bin", 123_398, None),
        ("velodyne/vlp16_dual.scan00.xyzir.bin", 14_981, Some(15)),
        ("robosense/helios16p.scan00.xyzir.bin", 15_258, Some(15)),
    ];
    for (name, points, last_ring) in expected {
        let found = files::read(&data::path(name)).unwrap();
        assert_eq!(found.points.len(), points, "{name}");
        assert_eq!(found.rings.and_then(|rings| rings.into_iter().max()), last_ring, "{name}");
    }
}

pub fn pcd_files_are_what_pcd_rs_reads() {
    for name in ["hesai/pandar40p_dual.reference.pcd", "hesai/xt32_dual.reference.pcd"] {
        let path = data::path(name);
        let records = DynReader::open(&path).unwrap().map(|record| record.unwrap().to_xyz().unwrap());
        assert_eq!(files::read(&path).unwrap().points, records.collect::<Vec<[f32; 3]>>());
    }
}
