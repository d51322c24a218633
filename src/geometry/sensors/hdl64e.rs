//! Velodyne HDL-64E, the unit on KITTI's car.
//!
//! The numbers are what `flicr calibrate` makes of 29 raw KITTI scans; they hold for every raw KITTI drive that was
//! tried. Upper block: beams 0 to 31, lower block: beams 32 to 63.
//!
//! In KITTI's files a beam's sideways offset turns a return, but does not take it farther from the axis
//! ([`SensorGrid::range_from_axis`]): of every beam apart, points lie `h^2 / 2a` nearer than they would otherwise, 34 um
//! at 10 m.

use crate::geometry::{Beam, SensorGrid};

/// Encoder ticks a turn: steps of 0.09 degrees.
pub const TICKS: u32 = 4000;

/// One range count, in meters.
pub const RANGE_UNIT_M: f64 = 0.002;

/// The grid of KITTI's unit.
pub const GRID: SensorGrid<'static> = SensorGrid {
    name: "HDL-64E (KITTI)",
    beams: &BEAMS,
    ticks: TICKS,
    clockwise: false,
    zero_rad: 0.0,
    range_unit_m: RANGE_UNIT_M as f32,
    range_from_axis: true,
};

/// The same, with each laser's own angle in its azimuth phase: here all lasers fire at the same ticks.
pub const FIRING_GRID: SensorGrid<'static> =
    SensorGrid { name: "HDL-64E (KITTI), by firings", beams: &FIRING_BEAMS, ..GRID };

/// Ticks by which each laser looks behind, highest first; found where the ticks of all lasers fall together, and the
/// same on every raw KITTI scan that was tried.
#[rustfmt::skip]
pub const TICKS_BEHIND: [i8; 64] = [
     -5,  21,  43,  68, -44, -19,   4,  29,  51,  76, -52, -27,  -5,  20,  43,  67,
    -43, -19,   4,  29,  51,  76, -52, -27,  -5,  20,  44,  67, -44, -19,   3,  29,
    -13,  23,  59,  97, -73, -37,   0,  37,  73, 111, -88, -51, -14,  24,  60,  98,
    -76, -38,  -1,  37,  74, 113, -91, -53, -16,  24,  62, 100, -79, -40,  -2,  37,
];

/// The beams of [`FIRING_GRID`].
pub static FIRING_BEAMS: [Beam; 64] = {
    let (mut beams, mut row) = (BEAMS, 0);
    while row < beams.len() {
        let behind_rad = TICKS_BEHIND[row] as f64 * (2.0 * core::f64::consts::PI / TICKS as f64);
        beams[row].azimuth_phase_rad = (beams[row].azimuth_phase_rad as f64 - behind_rad) as f32;
        row += 1;
    }
    beams
};

/// A beam as the fit gives it: slope, vertical and horizontal offset in meters, azimuth phase in degrees, range phase in
/// meters.
const fn beam(slope: f64, z_offset_m: f64, h_offset_m: f64, azimuth_phase_deg: f64, range_phase_m: f64) -> Beam {
    Beam {
        slope: slope as f32,
        z_offset_m: z_offset_m as f32,
        h_offset_m: h_offset_m as f32,
        azimuth_phase_rad: (azimuth_phase_deg * (core::f64::consts::PI / 180.0)) as f32,
        range_phase_m: range_phase_m as f32,
    }
}

/// The 64 beams, highest first.
#[rustfmt::skip]
#[expect(clippy::unreadable_literal, reason = "as the fit printed them")]
pub static BEAMS: [Beam; 64] = [
    beam( 0.033814670,  0.209124,  0.026000, -0.036360, -0.000571),
    beam( 0.027477800,  0.208628, -0.026002,  0.027592,  0.000173),
    beam( 0.022776240,  0.208265,  0.026001,  0.025224,  0.000671),
    beam( 0.015212873,  0.207691, -0.026000,  0.043046,  0.000911),
    beam( 0.010102482,  0.207310,  0.026002,  0.011646,  0.000101),
    beam( 0.003152376,  0.206801, -0.026000,  0.009599,  0.000000),
    beam(-0.001549193,  0.206462,  0.026002, -0.010960,  0.000214),
    beam(-0.007886063,  0.206012, -0.026000, -0.011926,  0.000644),
    beam(-0.014018529,  0.205585,  0.026002, -0.006993, -0.000573),
    beam(-0.020968648,  0.205110, -0.026001, -0.012416, -0.000408),
    beam(-0.026079038,  0.204768,  0.026001, -0.010633, -0.000816),
    beam(-0.032007087,  0.204376, -0.026005, -0.007837,  0.000049),
    beam(-0.038548354,  0.203952,  0.026004,  0.010967, -0.000195),
    beam(-0.044476430,  0.203576, -0.025998, -0.040867, -0.000976),
    beam(-0.050200034,  0.203219,  0.026001,  0.035672,  0.000874),
    beam(-0.056536913,  0.202831, -0.026002, -0.044865,  0.000064),
    beam(-0.061851720,  0.202512,  0.025997,  0.035559,  0.000016),
    beam(-0.068801850,  0.202102, -0.025997, -0.044504,  0.000888),
    beam(-0.073707810,  0.201819,  0.025998,  0.029674,  0.000182),
    beam(-0.080249086,  0.201448, -0.026001,  0.025158,  0.000453),
    beam(-0.085972760,  0.201131,  0.026005,  0.002326,  0.000628),
    beam(-0.091900800,  0.200808, -0.025993, -0.002423,  0.000334),
    beam(-0.098237660,  0.200470,  0.025994,  0.035138, -0.000712),
    beam(-0.104370120,  0.200149, -0.026011,  0.043195,  0.000321),
    beam(-0.110911414,  0.199816,  0.025998,  0.013566, -0.000414),
    beam(-0.117043875,  0.199510, -0.026006,  0.003945,  0.000814),
    beam(-0.122767460,  0.199230,  0.026008,  0.005551, -0.000955),
    beam(-0.127877900,  0.198986, -0.026005, -0.033071,  0.000328),
    beam(-0.134828050,  0.198660,  0.025992,  0.000473,  0.000393),
    beam(-0.141573760,  0.198352, -0.026001,  0.006839, -0.000764),
    beam(-0.146070880,  0.198151,  0.025994, -0.042510,  0.000803),
    beam(-0.153225470,  0.197839, -0.025986,  0.036528, -0.000690),
    beam(-0.158849980,  0.125838,  0.026006, -0.016099, -0.000717),
    beam(-0.168661820,  0.125416, -0.025998, -0.012884,  0.000517),
    beam(-0.177451860,  0.125048,  0.025995, -0.031193,  0.000789),
    beam(-0.184810620,  0.124743, -0.025997,  0.032526, -0.000954),
    beam(-0.193600600,  0.124388,  0.026000,  0.038021,  0.000203),
    beam(-0.205252290,  0.123927, -0.025987,  0.030726,  0.000157),
    beam(-0.214655940,  0.123567,  0.026007,  0.043668,  0.000776),
    beam(-0.222832050,  0.123255, -0.026006, -0.020171, -0.000346),
    beam(-0.231622130,  0.122930,  0.025996,  0.015702, -0.000487),
    beam(-0.239798300,  0.122629, -0.025998,  0.008419, -0.000332),
    beam(-0.250224000,  0.122261,  0.026001,  0.022141,  0.000660),
    beam(-0.260444370,  0.121901, -0.025971, -0.038851, -0.000745),
    beam(-0.271483030,  0.121527,  0.026006,  0.018006,  0.000124),
    beam(-0.280272630,  0.121233, -0.025991,  0.023149, -0.000452),
    beam(-0.290084420,  0.120911,  0.026020, -0.018578,  0.000958),
    beam(-0.297239360,  0.120683, -0.026007, -0.030797, -0.000860),
    beam(-0.309299800,  0.120303,  0.026011,  0.028431, -0.000770),
    beam(-0.319724320,  0.119980, -0.026013, -0.044986,  0.000042),
    beam(-0.331172400,  0.119638,  0.025989,  0.020530,  0.000062),
    beam(-0.340371640,  0.119369, -0.026005, -0.040324,  0.000629),
    beam(-0.350591330,  0.119068,  0.026013, -0.018457,  0.000848),
    beam(-0.358768370,  0.118837, -0.026028,  0.015118, -0.000119),
    beam(-0.368375480,  0.118567,  0.025991,  0.010554, -0.000868),
    beam(-0.379618380,  0.118258, -0.025986,  0.016934,  0.001016),
    beam(-0.390248840,  0.117979,  0.025972, -0.023179, -0.000047),
    beam(-0.402719000,  0.117646, -0.025983,  0.030377, -0.000627),
    beam(-0.412937500,  0.117373,  0.025992,  0.034863,  0.000136),
    beam(-0.421524500,  0.117159, -0.026006,  0.007081, -0.000584),
    beam(-0.431131570,  0.116914,  0.025987,  0.035037, -0.000393),
    beam(-0.444623560,  0.116577, -0.026008, -0.033104, -0.000251),
    beam(-0.455865680,  0.116301,  0.026005, -0.020521,  0.000998),
    beam(-0.466291000,  0.116051, -0.025986, -0.031382,  0.000625),
];
