//! Bad packets among a capture's: refused or used, the neighbours stay as they were.

use super::bench::{AFTER, BEFORE, Bench};
use super::captures::payloads;
use flicr::packet::Sensor;

pub fn captured_packets_survive_every_flipped_bit() {
    for capture in ["velodyne/vlp16_dual", "velodyne/vlp32c_single", "hesai/pandar40p_dual", "hesai/xt32_dual"] {
        let packets = payloads(&format!("{capture}.pcap"), 2368);
        let bench = Bench::new(packets[40..40 + BEFORE + 1 + AFTER].to_vec(), Sensor::Auto);
        let good = bench.packets[bench.bad_at].clone();
        for bit in 0..good.len() * 8 {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            let _ = bench.check(&bad);
        }
    }
}
