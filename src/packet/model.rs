//! The sensors whose packets are understood, and the integers that describe them.
//!
//! Everything here is in the sensor's own units, so that the packet path needs no float. What the
//! numbers mean in metres and radians is [`crate::geometry::sensors`]' business.

/// A sensor whose packets tell which sensor it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Model {
    /// Velodyne VLP-16 and Puck LITE.
    Vlp16,
    /// Velodyne Puck Hi-Res: a VLP-16 with beams 1.33 degrees apart.
    PuckHiRes,
    /// Velodyne VLP-32C (Ultra Puck).
    Vlp32c,
    /// Velodyne HDL-32E, firmware 2.2.20 or newer (older ones do not name themselves).
    Hdl32e,
    /// Velodyne VLS-128 (Alpha Prime).
    Vls128,
    /// Hesai Pandar40P and Pandar40M.
    Pandar40p,
    /// Hesai Pandar64.
    Pandar64,
    /// Hesai PandarXT-32.
    PandarXt32,
}

/// A sensor in integers.
///
/// `elevation_mdeg`, `azimuth_mdeg` and `fire_ns` are in the *packet's* channel order;
/// `beam_of_channel` gives the row of each, row 0 being the highest.
#[derive(Debug)]
#[non_exhaustive]
pub struct ModelFacts {
    /// As printed on the sensor.
    pub name: &'static str,
    /// Azimuth ticks a turn. All of these sensors count 0.01 degree, clockwise seen from above.
    pub ticks_per_turn: u16,
    /// One range count, in micrometres.
    pub range_unit_um: u16,
    /// Time from one firing of all beams to the next, in nanoseconds.
    pub period_ns: u32,
    /// Row of each channel.
    pub beam_of_channel: &'static [u8],
    /// Elevation of each channel, in thousandths of a degree.
    pub elevation_mdeg: &'static [i32],
    /// What to add to a column's azimuth for each channel, in thousandths of a degree, clockwise.
    pub azimuth_mdeg: &'static [i32],
    /// When each channel fires, in nanoseconds from the column's own time.
    ///
    /// A column's tick holds at the column's own time; a beam that fires `f` ns later looks
    /// `f / period_ns` of a column's step ([`Column::step_q8`](super::Column::step_q8)) further.
    /// That phase is a constant of the beam and the rotation rate, so it is left to the geometry and the
    /// packet path stays in integers.
    pub fire_ns: &'static [i32],
}

impl ModelFacts {
    /// Beams of the sensor: rows of the range image.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.beam_of_channel.len()
    }
}

impl Model {
    /// The byte by which packets name the sensor: Velodyne's product byte, Hesai's channel count.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Vlp16 => 0x22,
            Self::PuckHiRes => 0x24,
            // 40 is both a product byte and a count; the packets' lengths tell them apart.
            Self::Vlp32c | Self::Pandar40p => 0x28,
            Self::Hdl32e => 0x21,
            Self::Vls128 => 0xa1,
            Self::Pandar64 => 64,
            Self::PandarXt32 => 32,
        }
    }

    /// The sensor in integers.
    #[must_use]
    pub const fn facts(self) -> &'static ModelFacts {
        match self {
            Self::Vlp16 => &VLP16,
            Self::PuckHiRes => &PUCK_HI_RES,
            Self::Vlp32c => &VLP32C,
            Self::Hdl32e => &HDL32E,
            Self::Vls128 => &VLS128,
            Self::Pandar40p => &PANDAR40P,
            Self::Pandar64 => &PANDAR64,
            Self::PandarXt32 => &PANDAR_XT32,
        }
    }
}

/// Ticks a turn of every Velodyne and Hesai sensor here: 0.01 degree each.
pub const TICKS_PER_TURN: u16 = 36_000;

/// Rows of channels by their elevations: row = number of channels that look higher.
///
/// No two channels of a sensor have the same elevation.
const fn rank<const N: usize>(elevation: &[i32; N]) -> [u8; N] {
    let mut rows = [0; N];
    let mut i = 0;
    while i < N {
        let mut j = 0;
        while j < N {
            if elevation[j] > elevation[i] {
                rows[i] += 1;
            }
            j += 1;
        }
        i += 1;
    }
    rows
}

/// `group` channels fire together, `spacing_ns` after the group before.
const fn ramp<const N: usize>(start_ns: i32, spacing_ns: i32, group: i32) -> [i32; N] {
    let mut fire = [0; N];
    let mut i = 0;
    while i < N {
        fire[i] = start_ns + i as i32 / group * spacing_ns;
        i += 1;
    }
    fire
}

// VLP-16 and Puck Hi-Res: Velodyne 63-9243 Rev E, chapter 9 (elevations, 2.304 us a channel, 55.296 us a cycle, 2 mm); the
// Hi-Res' elevations are those of VeloView's calibration file.
const VLP16_ELEVATION: [i32; 16] = [
    -15_000, 1_000, -13_000, 3_000, -11_000, 5_000, -9_000, 7_000, -7_000, 9_000, -5_000, 11_000, -3_000, 13_000,
    -1_000, 15_000,
];
const PUCK_HI_RES_ELEVATION: [i32; 16] = [
    -10_000, 667, -8_667, 2_000, -7_333, 3_333, -6_000, 4_667, -4_667, 6_000, -3_333, 7_333, -2_000, 8_667, -667,
    10_000,
];

static VLP16: ModelFacts = ModelFacts {
    name: "VLP-16",
    ticks_per_turn: TICKS_PER_TURN,
    range_unit_um: 2_000,
    period_ns: 55_296,
    beam_of_channel: &rank(&VLP16_ELEVATION),
    elevation_mdeg: &VLP16_ELEVATION,
    azimuth_mdeg: &[0; 16],
    fire_ns: &ramp::<16>(0, 2_304, 1),
};

static PUCK_HI_RES: ModelFacts = ModelFacts {
    name: "Puck Hi-Res",
    ticks_per_turn: TICKS_PER_TURN,
    range_unit_um: 2_000,
    period_ns: 55_296,
    beam_of_channel: &rank(&PUCK_HI_RES_ELEVATION),
    elevation_mdeg: &PUCK_HI_RES_ELEVATION,
    azimuth_mdeg: &[0; 16],
    fire_ns: &ramp::<16>(0, 2_304, 1),
};

// VLP-32C: Velodyne 63-9325 Rev C, chapter 9 (channels fire in pairs every 2.304 us, 4 mm).
const VLP32C_ELEVATION: [i32; 32] = [
    -25_000, -1_000, -1_667, -15_639, -11_310, 0, -667, -8_843, -7_254, 333, -333, -6_148, -5_333, 1_333, 667, -4_000,
    -4_667, 1_667, 1_000, -3_667, -3_333, 3_333, 2_333, -2_667, -3_000, 7_000, 4_667, -2_333, -2_000, 15_000, 10_333,
    -1_333,
];

static VLP32C: ModelFacts = ModelFacts {
    name: "VLP-32C",
    ticks_per_turn: TICKS_PER_TURN,
    range_unit_um: 4_000,
    period_ns: 55_296,
    beam_of_channel: &rank(&VLP32C_ELEVATION),
    elevation_mdeg: &VLP32C_ELEVATION,
    azimuth_mdeg: &[
        1_400, -4_200, 1_400, -1_400, 1_400, -1_400, 4_200, -1_400, 1_400, -4_200, 1_400, -1_400, 4_200, -1_400, 4_200,
        -1_400, 1_400, -4_200, 1_400, -4_200, 4_200, -1_400, 1_400, -1_400, 1_400, -1_400, 1_400, -4_200, 4_200,
        -1_400, 1_400, -1_400,
    ],
    fire_ns: &ramp::<32>(0, 2_304, 2),
};

// HDL-32E: Velodyne 63-9277 Rev D (one channel every 1.152 us, 46.08 us a cycle, 2 mm).
const HDL32E_ELEVATION: [i32; 32] = [
    -30_670, -9_330, -29_330, -8_000, -28_000, -6_670, -26_670, -5_330, -25_330, -4_000, -24_000, -2_670, -22_670,
    -1_330, -21_330, 0, -20_000, 1_330, -18_670, 2_670, -17_330, 4_000, -16_000, 5_330, -14_670, 6_670, -13_330, 8_000,
    -12_000, 9_330, -10_670, 10_670,
];

static HDL32E: ModelFacts = ModelFacts {
    name: "HDL-32E",
    ticks_per_turn: TICKS_PER_TURN,
    range_unit_um: 2_000,
    period_ns: 46_080,
    beam_of_channel: &rank(&HDL32E_ELEVATION),
    elevation_mdeg: &HDL32E_ELEVATION,
    azimuth_mdeg: &[0; 32],
    fire_ns: &ramp::<32>(0, 1_152, 1),
};

// VLS-128: elevations and azimuth offsets as in VeloView's calibration file (which repeats Velodyne 63-9483's table);
// 8 channels fire together every 8/3 us, a pause of one such slot after the eighth group, 20 slots a
// cycle (53.333 us). Firmware 5.2.3 and newer is said to use 2.89 us: not confirmed.
const VLS128_ELEVATION: [i32; 128] = [
    -11_742, -1_990, 3_400, -5_290, -780, 4_610, -4_080, 1_310, -6_500, -1_110, 4_280, -4_410, 100, 6_480, -3_200,
    2_190, -3_860, 1_530, -9_244, -1_770, 2_740, -5_950, -560, 4_830, -2_980, 2_410, -6_280, -890, 3_620, -5_070, 320,
    7_580, -340, 5_180, -3_640, 1_750, -25_000, -2_430, 2_960, -5_730, 540, 9_700, -2_760, 2_630, -7_650, -1_550,
    3_840, -4_850, 3_180, -5_510, -120, 5_730, -4_300, 1_090, -16_042, -2_210, 4_060, -4_630, 760, 15_000, -3_420,
    1_970, -6_850, -1_330, -5_620, -230, 5_430, -3_530, 980, -19_582, -2_320, 3_070, -4_740, 650, 11_750, -2_650,
    1_860, -7_150, -1_440, 3_950, -2_100, 3_290, -5_400, -10, 4_500, -4_190, 1_200, -13_565, -1_220, 4_170, -4_520,
    870, 6_080, -3_310, 2_080, -6_650, 1_420, -10_346, -1_880, 3_510, -6_060, -670, 4_720, -3_970, 2_300, -6_390,
    -1_000, 4_390, -5_180, 210, 6_980, -3_090, 4_980, -3_750, 1_640, -8_352, -2_540, 2_850, -5_840, -450, 8_430,
    -2_870, 2_520, -6_170, -1_660, 3_730, -4_960, 430,
];

const fn vls128_azimuth() -> [i32; 128] {
    const OF_EIGHT: [i32; 8] = [6_354, 4_548, 2_732, 911, -911, -2_732, -4_548, -6_354];
    let mut offsets = [0; 128];
    let mut i = 0;
    while i < 128 {
        offsets[i] = OF_EIGHT[i % 8];
        i += 1;
    }
    offsets
}

const fn vls128_fire() -> [i32; 128] {
    let mut fire = [0; 128];
    let mut i = 0;
    while i < 128 {
        let slot = i / 8 + if i >= 64 { 1 } else { 0 };
        fire[i] = slot as i32 * 8_000 / 3;
        i += 1;
    }
    fire
}

static VLS128: ModelFacts = ModelFacts {
    name: "VLS-128",
    ticks_per_turn: TICKS_PER_TURN,
    range_unit_um: 4_000,
    period_ns: 53_333,
    beam_of_channel: &rank(&VLS128_ELEVATION),
    elevation_mdeg: &VLS128_ELEVATION,
    azimuth_mdeg: &vls128_azimuth(),
    fire_ns: &vls128_fire(),
};

// Pandar40P: Hesai's design table and laser firing times (HesaiLidar_General_SDK); each unit comes
// with its own angle file, which differs by up to 0.2 degree.
const PANDAR40P_ELEVATION: [i32; 40] = [
    15_000, 11_000, 8_000, 5_000, 3_000, 2_000, 1_670, 1_330, 1_000, 670, 330, 0, -330, -670, -1_000, -1_330, -1_660,
    -2_000, -2_330, -2_670, -3_000, -3_330, -3_670, -4_000, -4_330, -4_670, -5_000, -5_330, -5_670, -6_000, -7_000,
    -8_000, -9_000, -10_000, -11_000, -12_000, -13_000, -14_000, -19_000, -25_000,
];

const fn pandar40p_azimuth() -> [i32; 40] {
    const OF_THREE: [i32; 3] = [3_125, -5_208, -1_042];
    let mut offsets = [-1_042; 40];
    let mut i = 6;
    while i < 30 {
        offsets[i] = OF_THREE[i % 3];
        i += 1;
    }
    offsets
}

static PANDAR40P: ModelFacts = ModelFacts {
    name: "Pandar40P",
    ticks_per_turn: TICKS_PER_TURN,
    range_unit_um: 4_000,
    period_ns: 55_560,
    beam_of_channel: &rank(&PANDAR40P_ELEVATION),
    elevation_mdeg: &PANDAR40P_ELEVATION,
    azimuth_mdeg: &pandar40p_azimuth(),
    fire_ns: &[
        -42_220, -28_470, -16_040, -3_620, -45_490, -31_740, -47_460, -54_670, -20_620, -33_710, -40_910, -8_190,
        -20_620, -27_160, -50_730, -8_190, -14_740, -36_980, -45_490, -52_700, -23_890, -31_740, -38_950, -11_470,
        -18_650, -25_190, -48_760, -6_230, -12_770, -35_010, -21_920, -9_500, -43_520, -29_770, -17_350, -4_920,
        -42_220, -28_470, -16_040, -3_620,
    ],
};

// Pandar64: the same sources.
const PANDAR64_ELEVATION: [i32; 64] = [
    14_882, 11_032, 8_059, 5_057, 3_040, 2_028, 1_860, 1_688, 1_522, 1_351, 1_184, 1_013, 846, 675, 508, 337, 169, 0,
    -169, -337, -508, -675, -845, -1_013, -1_184, -1_351, -1_522, -1_688, -1_860, -2_028, -2_198, -2_365, -2_536,
    -2_700, -2_873, -3_040, -3_210, -3_375, -3_548, -3_712, -3_884, -4_050, -4_221, -4_385, -4_558, -4_720, -4_892,
    -5_057, -5_229, -5_391, -5_565, -5_726, -5_898, -6_061, -7_063, -8_059, -9_060, -9_885, -11_032, -12_006, -12_974,
    -13_930, -18_889, -24_897,
];

const fn pandar64_azimuth() -> [i32; 64] {
    const OF_SIX: [i32; 6] = [1_042, 3_125, 5_208, -5_208, -3_125, -1_042];
    let mut offsets = [-1_042; 64];
    let mut i = 6;
    while i < 54 {
        offsets[i] = OF_SIX[i % 6];
        i += 1;
    }
    offsets
}

static PANDAR64: ModelFacts = ModelFacts {
    name: "Pandar64",
    ticks_per_turn: TICKS_PER_TURN,
    range_unit_um: 4_000,
    period_ns: 55_560,
    beam_of_channel: &rank(&PANDAR64_ELEVATION),
    elevation_mdeg: &PANDAR64_ELEVATION,
    azimuth_mdeg: &pandar64_azimuth(),
    fire_ns: &[
        -23_180, -21_876, -20_572, -19_268, -17_964, -16_660, -11_444, -46_796, -7_532, -36_956, -50_732, -54_668,
        -40_892, -44_828, -31_052, -34_988, -48_764, -52_700, -38_924, -42_860, -29_084, -33_020, -46_796, -25_148,
        -36_956, -50_732, -27_116, -40_892, -44_828, -31_052, -34_988, -48_764, -25_148, -38_924, -42_860, -29_084,
        -33_020, -52_700, -6_228, -54_668, -15_356, -27_116, -10_140, -23_180, -4_924, -21_876, -14_052, -17_964,
        -8_836, -19_268, -3_620, -20_572, -12_748, -16_660, -7_532, -11_444, -6_228, -15_356, -10_140, -4_924, -3_620,
        -14_052, -8_836, -12_748,
    ],
};

// PandarXT-32: Hesai's user manual, appendices I and II (1 degree apart, 0.28 + 1.512 us a channel).
const fn xt32_elevation() -> [i32; 32] {
    let mut elevation = [0; 32];
    let mut i = 0;
    while i < 32 {
        elevation[i] = 15_000 - 1_000 * i as i32;
        i += 1;
    }
    elevation
}
const XT32_ELEVATION: [i32; 32] = xt32_elevation();

static PANDAR_XT32: ModelFacts = ModelFacts {
    name: "PandarXT-32",
    ticks_per_turn: TICKS_PER_TURN,
    range_unit_um: 4_000,
    period_ns: 50_000,
    beam_of_channel: &rank(&XT32_ELEVATION),
    elevation_mdeg: &XT32_ELEVATION,
    azimuth_mdeg: &[0; 32],
    fire_ns: &ramp::<32>(280, 1_512, 1),
};
