//! Ouster captures against the vendor's SDK: every pixel, every position.

use super::captures::{npy_u32, payloads, xyzir};
use super::stream::Stream;
use crate::common::data;
use flicr::geometry::sensors::ouster::OusterSensor;
use flicr::packet::{ReturnPolicy, Sensor};

struct Capture {
    sensor: OusterSensor,
    stream: Stream,
    scan: String,
}

fn capture(pcap: &str, json: &str) -> Capture {
    let packets = payloads(&format!("ouster/{pcap}.pcap"), 7502);
    let json = std::fs::read_to_string(data::path(&format!("ouster/{json}.json"))).expect("reads");
    let sensor = OusterSensor::from_json(&json).expect("metadata");
    let stream = Stream::of(&packets, Sensor::Ouster(sensor.format), ReturnPolicy::Strongest);
    assert_eq!(stream.stats.refused(), 0, "{:?}", stream.errors);
    assert_eq!(stream.stats.lost_columns, 0);
    Capture { sensor, stream, scan: format!("ouster/{pcap}.scan000") }
}

impl Capture {
    /// Ranges in millimetres, destaggered.
    fn image_mm(&self) -> Vec<u32> {
        let columns = usize::from(self.sensor.format.columns_per_frame);
        let unit_mm = u32::from(self.sensor.format.profile.range_unit_um()) / 1000;
        let mut image = vec![0; columns * self.sensor.beams.len()];
        for ours in self.stream.returns.iter().filter(|ours| ours.turn == 0) {
            let row = usize::from(ours.beam);
            let shift = self.sensor.shift_by_row[row];
            let column = (i32::from(ours.column) + shift).rem_euclid(columns as i32) as usize;
            image[row * columns + column] = ours.count * unit_mm;
        }
        image
    }

    /// Every position of the first turn, by row and column as fired, as the reference.
    fn positions(&self) -> Vec<[f64; 3]> {
        let mut placed: Vec<((u8, u16), [f64; 3])> = Vec::new();
        for ours in self.stream.returns.iter().filter(|ours| ours.turn == 0) {
            let row = usize::from(ours.beam);
            let beam = &self.sensor.beams[row];
            let theta = self.sensor.spin.theta_rad(ours.tick, ours.step_q8, 0, beam);
            let range =
                f64::from(ours.count) * f64::from(self.sensor.spin.range_unit_m) + f64::from(beam.range_phase_m);
            let v = f64::from(beam.slope).atan();
            let vo = f64::from(beam.z_offset_m) * v.cos();
            let (a, h) = (range * v.cos() - vo * v.sin(), f64::from(beam.h_offset_m));
            placed.push((
                (ours.beam, ours.column),
                [a * theta.cos() + h * theta.sin(), a * theta.sin() - h * theta.cos(), range * v.sin() + vo * v.cos()],
            ));
        }
        placed.sort_by_key(|&(pixel, _)| pixel);
        placed.into_iter().map(|(_, position)| position).collect()
    }

    fn check(&self) {
        let (reference, columns) = npy_u32(&format!("{}.range_mm.npy", self.scan));
        assert_eq!(columns, usize::from(self.sensor.format.columns_per_frame));
        assert_eq!(self.image_mm(), reference);
        let points = xyzir(&format!("{}.xyzir.bin", self.scan));
        let ours = self.positions();
        assert_eq!(points.len(), ours.len());
        let worst = points.iter().zip(&ours).map(|(point, ours)| {
            let off = |axis: usize| (f64::from(point[axis]) - ours[axis]).powi(2);
            (off(0) + off(1) + off(2)).sqrt()
        });
        let worst = worst.fold(0.0, f64::max);
        println!("{}: {} points, worst {:.3} mm", self.sensor.name, ours.len(), worst * 1e3);
        assert!(worst <= f64::from(self.sensor.spin.range_unit_m) + 0.002);
    }
}

pub fn os0_32_dual_equals_the_sdk() {
    let name = "OS-0-32-U1_v2.2.0_1024x10";
    capture(name, name).check();
}

pub fn os1_128_low_rate_equals_the_sdk() {
    // One JSON serves the sensor's other recordings too: this one was made in another profile.
    capture("OS-1-128_v2.3.0_1024x10_lb_n3", "OS-1-128_v2.3.0_1024x10").check();
}
