//! Writes packets of every model: the formats a second time, from the manuals' byte tables, sharing
//! nothing with the reader.
#![allow(dead_code, reason = "each test uses a part")]

use flicr::packet::{Model, OusterFormat, OusterProfile};

/// Intensity and range count of one beam; count 0 is no return.
pub type Echo = (u16, u8);

/// A stream of firings: firing `n` starts at `n * step` ticks and `n * period_ns`.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    pub model: Model,
    pub dual: bool,
    /// Ticks a firing; even for VLP-16, whose block holds two.
    pub step: u32,
    pub start_tick: u32,
}

/// Sizes of a format, by hand.
struct Shape {
    channels: usize,
    firings: usize,
    period_ns: u64,
}

impl Plan {
    pub fn new(model: Model, dual: bool) -> Self {
        Self { model, dual, step: 20, start_tick: 0 }
    }

    fn shape(&self) -> Shape {
        let (channels, firings, period_ns) = match self.model {
            Model::Vlp16 | Model::PuckHiRes => (16, 24, 55_296),
            Model::Vlp32c => (32, 12, 55_296),
            Model::Hdl32e => (32, 12, 46_080),
            // A dual packet has one firing of four banks twice, and four unused blocks.
            Model::Vls128 if self.dual => (128, 2, 53_333),
            Model::Vls128 => (128, 3, 53_333),
            Model::Pandar40p => (40, 10, 55_560),
            Model::Pandar64 => (64, 6, 55_560),
            Model::PandarXt32 => (32, 8, 50_000),
            other => panic!("no shape for {other:?}"),
        };
        Shape { channels, firings: if self.dual { firings / 2 } else { firings }, period_ns }
    }

    pub fn channels(&self) -> usize {
        self.shape().channels
    }

    pub fn firings_a_packet(&self) -> usize {
        self.shape().firings
    }

    pub fn tick(&self, firing: usize) -> u16 {
        ((u64::from(self.start_tick) + firing as u64 * u64::from(self.step)) % 36_000) as u16
    }

    pub fn time_ns(&self, firing: usize) -> u64 {
        firing as u64 * self.shape().period_ns
    }

    /// What `channel` sees in `firing`, as (last, strongest): a fixed scramble of both.
    pub fn echoes(firing: usize, channel: usize) -> [Echo; 2] {
        let mut state = (firing as u64 * 1009 + channel as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut next = || {
            state ^= state >> 29;
            state = state.wrapping_mul(0xbf58_476d_1ce4_e5b9);
            (state >> 40) as u32
        };
        let (near, far) = (1 + next() % 20_000, 20_001 + next() % 40_000);
        let (weak, strong) = ((next() % 100) as u8, 100 + (next() % 156) as u8);
        match next() % 5 {
            0 => [(0, 0), (0, 0)],
            1 => [(near as u16, strong), (near as u16, strong)],
            2 => [(far as u16, weak), (near as u16, strong)],
            // The last is the strongest: the second strongest stands in its place.
            3 => [(far as u16, strong), (near as u16, weak)],
            _ => [(far as u16, weak), (far as u16, weak)],
        }
    }

    /// `count` packets from the start of the stream.
    pub fn packets(&self, count: usize) -> Vec<Vec<u8>> {
        (0..count).map(|nth| self.packet(nth)).collect()
    }

    pub fn packet(&self, nth: usize) -> Vec<u8> {
        let first = nth * self.firings_a_packet();
        match self.model {
            Model::Vlp16 => self.velodyne(first, 0x22),
            Model::PuckHiRes => self.velodyne(first, 0x24),
            Model::Vlp32c => self.velodyne(first, 0x28),
            Model::Hdl32e => self.velodyne(first, 0x21),
            Model::Vls128 => self.vls128(first),
            Model::Pandar40p => self.pandar40p(first),
            Model::Pandar64 => self.pandar64(first, nth as u32),
            Model::PandarXt32 => self.pandar_xt(first, nth as u32),
            other => panic!("no writer for {other:?}"),
        }
    }

    /// Returns a firing is written with: both of a dual stream, the last of a single one.
    fn layers(&self) -> &'static [usize] {
        if self.dual { &[0, 1] } else { &[0] }
    }

    fn put_cells(out: &mut Vec<u8>, firing: usize, channels: std::ops::Range<usize>, layer: usize, pad: usize) {
        for channel in channels {
            let (count, intensity) = Self::echoes(firing, channel)[layer];
            out.extend(count.to_le_bytes());
            out.push(intensity);
            out.extend(std::iter::repeat_n(0x5a, pad));
        }
    }

    fn velodyne(&self, first: usize, product: u8) -> Vec<u8> {
        let mut out = Vec::new();
        let in_block = 32 / self.channels();
        for block in (first..first + self.firings_a_packet()).step_by(in_block) {
            for &layer in self.layers() {
                out.extend([0xff, 0xee]);
                out.extend(self.tick(block).to_le_bytes());
                for firing in block..block + in_block {
                    Self::put_cells(&mut out, firing, 0..self.channels(), layer, 0);
                }
            }
        }
        self.velodyne_tail(out, first, product)
    }

    fn velodyne_tail(&self, mut out: Vec<u8>, first: usize, product: u8) -> Vec<u8> {
        out.extend((((self.time_ns(first) / 1000) % 3_600_000_000) as u32).to_le_bytes());
        out.extend([if self.dual { 0x39 } else { 0x38 }, product]);
        assert_eq!(out.len(), 1206);
        out
    }

    fn vls128(&self, first: usize) -> Vec<u8> {
        let mut out = Vec::new();
        for firing in first..first + self.firings_a_packet() {
            for (bank, flag) in [0xee, 0xdd, 0xcc, 0xbb].into_iter().enumerate() {
                for &layer in self.layers() {
                    out.extend([0xff, flag]);
                    out.extend(self.tick(firing).to_le_bytes());
                    Self::put_cells(&mut out, firing, bank * 32..bank * 32 + 32, layer, 0);
                }
            }
        }
        out.resize(1200, 0);
        self.velodyne_tail(out, first, 0xa1)
    }

    /// 2021-05-06 07:08:09 and what follows; the stream must not run for more than 50 s.
    fn hesai_clock(ns: u64, year: u8) -> ([u8; 6], u32) {
        let micros = ns / 1000;
        let second = 9 + (micros / 1_000_000) as u8;
        ([year, 5, 6, 7, 8, second], (micros % 1_000_000) as u32)
    }

    fn pandar_tail(&self, first: usize, last_firing_ns: u64) -> Vec<u8> {
        let last = first + self.firings_a_packet() - 1;
        let (date, micros) = Self::hesai_clock(self.time_ns(last) + last_firing_ns, 21);
        let mut tail = vec![0; 8];
        tail.extend(600u16.to_le_bytes());
        tail.extend(micros.to_le_bytes());
        tail.extend([if self.dual { 0x39 } else { 0x38 }, 0x42]);
        tail.extend(date);
        tail
    }

    fn pandar40p(&self, first: usize) -> Vec<u8> {
        let mut out = Vec::new();
        for firing in first..first + self.firings_a_packet() {
            for &layer in self.layers() {
                out.extend([0xff, 0xee]);
                out.extend(self.tick(firing).to_le_bytes());
                Self::put_cells(&mut out, firing, 0..40, layer, 0);
            }
        }
        out.extend(self.pandar_tail(first, 28_580));
        assert_eq!(out.len(), 1262);
        out
    }

    fn pandar64(&self, first: usize, sequence: u32) -> Vec<u8> {
        let mut out = vec![0xee, 0xff, 64, 6, u8::from(self.dual), 4, 0, 0];
        for firing in first..first + self.firings_a_packet() {
            for &layer in self.layers() {
                out.extend(self.tick(firing).to_le_bytes());
                Self::put_cells(&mut out, firing, 0..64, layer, 0);
            }
        }
        out.extend(self.pandar_tail(first, 42_580));
        out.extend(sequence.to_le_bytes());
        assert_eq!(out.len(), 1198);
        out
    }

    fn pandar_xt(&self, first: usize, sequence: u32) -> Vec<u8> {
        let mut out = vec![0xee, 0xff, 6, 1, 0, 0, 32, 8, u8::from(self.dual), 4, 2, 1];
        for firing in first..first + self.firings_a_packet() {
            for &layer in self.layers() {
                out.extend(self.tick(firing).to_le_bytes());
                Self::put_cells(&mut out, firing, 0..32, layer, 1);
            }
        }
        let last = first + self.firings_a_packet() - 1;
        let (date, micros) = Self::hesai_clock(self.time_ns(last), 121);
        out.extend([0; 10]);
        out.push(if self.dual { 0x39 } else { 0x38 });
        out.extend(600u16.to_le_bytes());
        out.extend(date);
        out.extend(micros.to_le_bytes());
        out.push(0x42);
        out.extend(sequence.to_le_bytes());
        assert_eq!(out.len(), 1080);
        out
    }
}

/// Measurement `id` of `frame`, row `row`: (millimetres or counts, reflectivity), second return.
pub fn ouster_echoes(frame: u16, id: u16, row: usize) -> [(u32, u8); 2] {
    let scramble = (u32::from(frame) << 16 | u32::from(id)).wrapping_mul(2_654_435_761) ^ (row as u32) << 9;
    let first = if scramble.is_multiple_of(7) { 0 } else { 1 + scramble % 30_000 };
    let second = if scramble.is_multiple_of(3) { first + 500 } else { 0 };
    [(first, (scramble >> 8) as u8), (if first == 0 { 0 } else { second }, (scramble >> 16) as u8)]
}

/// One Ouster packet of 16 columns from `first_id` on.
pub fn ouster(format: &OusterFormat, frame: u16, first_id: u16) -> Vec<u8> {
    let legacy = format.profile == OusterProfile::Legacy;
    let mut out = Vec::new();
    if !legacy {
        out.extend(1u16.to_le_bytes());
        out.extend(frame.to_le_bytes());
        out.resize(32, 0);
    }
    for id in first_id..first_id + u16::from(format.columns_per_packet) {
        let turn_ns = 100_000_000;
        let columns = u64::from(format.columns_per_frame);
        let time_ns = u64::from(frame) * turn_ns + u64::from(id) * turn_ns / columns;
        out.extend(time_ns.to_le_bytes());
        out.extend(id.to_le_bytes());
        if legacy {
            out.extend(frame.to_le_bytes());
            out.extend((u32::from(id) * 88).to_le_bytes());
        } else {
            out.extend(1u16.to_le_bytes());
        }
        for row in 0..usize::from(format.rows) {
            pixel(&mut out, format.profile, ouster_echoes(frame, id, row));
        }
        if legacy {
            out.extend(u32::MAX.to_le_bytes());
        }
    }
    if !legacy {
        out.extend([0; 32]);
    }
    out
}

fn pixel(out: &mut Vec<u8>, profile: OusterProfile, [first, second]: [(u32, u8); 2]) {
    match profile {
        OusterProfile::Legacy => {
            out.extend((first.0 | 0x3 << 28).to_le_bytes());
            out.extend([first.1, 0, 0x77, 0x77, 0x66, 0x66, 0, 0]);
        }
        OusterProfile::Single => {
            out.extend((first.0 | 0x1f << 19).to_le_bytes());
            out.extend([first.1, 0, 0x77, 0x77, 0x66, 0x66, 0, 0]);
        }
        OusterProfile::Dual => {
            for (count, reflectivity) in [first, second] {
                out.extend((count | 0x1f << 19 | u32::from(reflectivity) << 24).to_le_bytes());
            }
            out.extend([0x77; 8]);
        }
        OusterProfile::LowRate => {
            out.extend((first.0 as u16 | 0x8000).to_le_bytes());
            out.extend([first.1, 0x66]);
        }
        other => panic!("no pixel for {other:?}"),
    }
}
