//! The bytes of a datagram: `docs/FORMAT.md` is the normative text; writing and reading side by side.
//!
//! ```text
//! datagram = header strip's code crc32
//! ```
//!
//! Every byte here comes once in 1400: what is mostly the same is left out, what is mostly small is short.

use crate::coder::ContextSettings;
use crate::coder::context::strip::Order;

/// First byte of every datagram; the low half is the format's version.
pub(super) const MAGIC: u8 = 0xf1;
pub(super) const CHECKSUM_LEN: usize = 4;
/// Most ticks from a column to the next.
pub(super) const RATE_MAX: u32 = 1 << 26;
/// Longest header.
pub(super) const HEADER_LEN_MAX: usize = 32;
/// Bytes that a datagram has besides its strip's code, at most.
pub const OVERHEAD_LEN: usize = HEADER_LEN_MAX + CHECKSUM_LEN;
/// Bytes of a datagram at most, unless told otherwise: they fit an Ethernet frame, tunnels included.
pub const DATAGRAM_LEN: usize = 1400;

/// Tier of a strip of one column whose levels stand as they are.
pub(super) const STORED: u8 = 3;
#[cfg(feature = "std")]
const TIER_MASK: u8 = 3;
const MEDIAN_EDGE_FLAG: u8 = 4;
const DEAD_ZONE_FLAG: u8 = 8;
const ALIGNED_FLAG: u8 = 16;
const LAST_FLAG: u8 = 32;
/// Noise and counts a level are not those of most sensors.
const SCALE_FLAG: u8 = 64;
/// One of several streams, or not every column.
const STREAM_FLAG: u8 = 128;
/// Unless said otherwise.
const USUAL_NOISE: u8 = ContextSettings::FINE.noise;

/// What a datagram says of its strip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct StripHeader {
    /// Whether the turn ends with this strip.
    pub last: bool,
    /// Range counts of a level.
    pub counts_a_level: u8,
    /// [`SensorGrid::checksum`](crate::geometry::SensorGrid::checksum). The low half is in the header, all of it in the
    /// checksum.
    pub sensor: u32,
    /// Which of the sender's streams.
    pub id: u8,
    pub turn: u16,
    /// Number of the strip in its turn, from 0.
    pub strip: u16,
    pub first_column: u16,
    /// 0 only in a datagram that says no more than that the turn is over.
    pub columns: u16,
    /// From each column to the next; 1 where there are all.
    pub stride: u8,
    /// Of the first column, in the sensor's clock, microseconds; wraps after 71 minutes.
    pub time_us: u32,
    /// Of the first tick.
    pub first_tick: u16,
    /// Ticks from each to the next, in the long run.
    pub rate_q10: u32,
    pub tier: u8,
    pub settings: ContextSettings,
    /// By which beams are aligned; 0 where columns are as fired.
    pub columns_a_turn: u16,
}

impl StripHeader {
    pub const fn order(&self) -> Order {
        if self.columns_a_turn == 0 { Order::AsFired } else { Order::Aligned }
    }

    /// Bytes that the header takes; not more than [`HEADER_LEN_MAX`].
    pub fn len(self) -> usize {
        self.to_bytes().1
    }

    /// Writes the header to the front of `out`, and the checksum behind `code_len` bytes of code; gives the datagram's
    /// length, 0 where `out` is too short.
    pub fn seal(&self, code_len: usize, out: &mut [u8]) -> usize {
        let (header, header_len) = self.to_bytes();
        let Some(datagram) = out.get_mut(..header_len + code_len + CHECKSUM_LEN) else { return 0 };
        let Some((checked, checksum)) = datagram.split_last_chunk_mut::<CHECKSUM_LEN>() else { return 0 };
        checked.iter_mut().zip(&header).take(header_len).for_each(|(to, from)| *to = *from);
        *checksum = crate::frame::checksum_of([&*checked, &self.sensor.to_le_bytes()]).to_le_bytes();
        datagram.len()
    }

    fn to_bytes(self) -> ([u8; HEADER_LEN_MAX], usize) {
        let mut bytes = Bytes { bytes: [0; HEADER_LEN_MAX], len: 0 };
        let ContextSettings { step, noise, predictor } = self.settings;
        let has_scale = noise != USUAL_NOISE || self.counts_a_level != 1;
        let has_stream = self.id != 0 || self.stride != 1;
        let flags = [
            (predictor == crate::coder::Predictor::MedianEdge, MEDIAN_EDGE_FLAG),
            (step.has_dead_zone(), DEAD_ZONE_FLAG),
            (self.order() == Order::Aligned, ALIGNED_FLAG),
            (self.last, LAST_FLAG),
            (has_scale, SCALE_FLAG),
            (has_stream, STREAM_FLAG),
        ];
        let flags = flags.into_iter().filter(|flag| flag.0).fold(0, |all, flag| all | flag.1);
        bytes.put(&[MAGIC, self.tier | flags]);
        for field in [self.sensor as u16, self.turn, self.first_column, self.columns] {
            bytes.put(&field.to_le_bytes());
        }
        bytes.put(&self.time_us.to_le_bytes());
        bytes.put(&self.first_tick.to_le_bytes());
        bytes.put_number(self.strip.into());
        bytes.put_number(self.rate_q10);
        bytes.put_number(step.levels().into());
        if self.order() == Order::Aligned {
            bytes.put_number(self.columns_a_turn.into());
        }
        if has_scale {
            bytes.put(&[noise, self.counts_a_level]);
        }
        if has_stream {
            bytes.put(&[self.id, self.stride]);
        }
        (bytes.bytes, bytes.len)
    }
}

struct Bytes {
    bytes: [u8; HEADER_LEN_MAX],
    len: usize,
}

impl Bytes {
    fn put(&mut self, field: &[u8]) {
        self.bytes.iter_mut().skip(self.len).zip(field).for_each(|(to, from)| *to = *from);
        self.len += field.len();
    }

    /// Seven bits a byte, the lowest first; the high bit says that more follow.
    fn put_number(&mut self, mut number: u32) {
        while number > 0x7f {
            self.put(&[number as u8 | 0x80]);
            number >>= 7;
        }
        self.put(&[number as u8]);
    }
}

#[cfg(feature = "std")]
pub(super) use read::Datagram;
#[cfg(feature = "std")]
pub use read::DatagramError;

#[cfg(feature = "std")]
mod read {
    use core::fmt;

    use super::{
        ALIGNED_FLAG, CHECKSUM_LEN, DEAD_ZONE_FLAG, LAST_FLAG, MAGIC, MEDIAN_EDGE_FLAG, RATE_MAX, SCALE_FLAG,
        STREAM_FLAG, StripHeader, TIER_MASK, USUAL_NOISE,
    };
    use crate::coder::{ContextSettings, Predictor, Step};
    use crate::error::PayloadFault;

    /// Fewest bytes of a datagram.
    const LEN_MIN: usize = 19 + CHECKSUM_LEN;
    /// Why a datagram was refused: nothing of it was used.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    #[non_exhaustive]
    pub enum DatagramError {
        /// Shorter than a datagram's header and checksum.
        Truncated {
            /// Bytes there are.
            have: usize,
            /// Bytes there should be at least.
            need: usize,
        },
        /// It does not begin as a datagram of this format and version does.
        Start {
            /// The first byte.
            found: u8,
        },
        /// Its bytes are not those that were sent.
        Checksum {
            /// As it stands in the datagram.
            stored: u32,
            /// As its bytes have it.
            computed: u32,
        },
        /// A field that no encoder writes.
        Field {
            /// Which.
            name: &'static str,
            /// What it holds.
            found: u32,
        },
        /// A sensor that the decoder was not told of.
        UnknownSensor {
            /// The low half of its checksum.
            sensor: u16,
        },
        /// More streams at a time than the decoder's limits allow.
        Streams {
            /// Streams that there may be.
            max: usize,
        },
        /// A strip's code that no encoder makes.
        Payload(PayloadFault),
        /// It belongs to a turn that was given out, or given up.
        TooLate {
            /// The turn.
            turn: u16,
        },
        /// It has been received before.
        Twice {
            /// The turn.
            turn: u16,
            /// The strip.
            strip: u16,
        },
        /// It does not agree with other strips of its turn: columns that they have, or a turn that has ended.
        Disagrees {
            /// The turn.
            turn: u16,
            /// The strip.
            strip: u16,
        },
    }

    impl fmt::Display for DatagramError {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            match *self {
                Self::Truncated { have, need } => write!(f, "datagram of {have} bytes: at least {need} expected"),
                Self::Start { found } => write!(f, "datagram begins with {found:#04x}: {MAGIC:#04x} expected"),
                Self::Checksum { stored, computed } => {
                    write!(f, "datagram's checksum is {stored:08x}, its bytes have {computed:08x}")
                }
                Self::Field { name, found } => write!(f, "datagram's {name} is {found}, which no encoder writes"),
                Self::UnknownSensor { sensor } => {
                    write!(f, "datagram of a sensor ....{sensor:04x} that is not known here")
                }
                Self::Streams { max } => write!(f, "datagram of one more stream than the {max} that are allowed"),
                Self::Payload(fault) => write!(f, "datagram's strip {fault}"),
                Self::TooLate { turn } => write!(f, "datagram of turn {turn}, which is over"),
                Self::Twice { turn, strip } => write!(f, "strip {strip} of turn {turn} has been received before"),
                Self::Disagrees { turn, strip } => {
                    write!(f, "strip {strip} does not agree with what was received of turn {turn}")
                }
            }
        }
    }

    impl core::error::Error for DatagramError {}

    /// A datagram that is long enough and begins as one.
    #[derive(Debug, Clone, Copy)]
    pub struct Datagram<'a> {
        checked: &'a [u8],
        stored: u32,
    }

    impl<'a> Datagram<'a> {
        pub fn new(datagram: &'a [u8]) -> Result<Self, DatagramError> {
            let truncated = DatagramError::Truncated { have: datagram.len(), need: LEN_MIN };
            let (checked, stored) = datagram.split_last_chunk::<CHECKSUM_LEN>().ok_or(truncated)?;
            if datagram.len() < LEN_MIN {
                return Err(truncated);
            }
            if checked[0] != MAGIC {
                return Err(DatagramError::Start { found: checked[0] });
            }
            Ok(Self { checked, stored: u32::from_le_bytes(*stored) })
        }

        /// The low half of its sensor's checksum.
        pub fn sensor(&self) -> u16 {
            u16::from_le_bytes([self.checked[2], self.checked[3]])
        }

        /// Checks it as one of this sensor; gives its header and its strip's code.
        pub fn of(&self, sensor: u32) -> Result<(StripHeader, &'a [u8]), DatagramError> {
            let (stored, computed) = (self.stored, crate::frame::checksum_of([self.checked, &sensor.to_le_bytes()]));
            if stored != computed {
                return Err(DatagramError::Checksum { stored, computed });
            }
            let mut bytes = Bytes(self.checked);
            let header = bytes.header(sensor)?;
            Ok((header, bytes.0))
        }
    }

    struct Bytes<'a>(&'a [u8]);

    impl Bytes<'_> {
        fn take<const N: usize>(&mut self) -> Result<[u8; N], DatagramError> {
            let (field, behind) = self.0.split_first_chunk().ok_or(wrong("length", self.0.len() as u32))?;
            self.0 = behind;
            Ok(*field)
        }

        fn u16(&mut self) -> Result<u16, DatagramError> {
            self.take().map(u16::from_le_bytes)
        }

        /// As short as it can be, and at most `max`.
        fn number(&mut self, name: &'static str, max: u32) -> Result<u32, DatagramError> {
            let mut number = 0;
            for place in (0..28).step_by(7) {
                let [byte] = self.take()?;
                number |= u32::from(byte & 0x7f) << place;
                if byte < 0x80 {
                    let is_short = byte > 0 || place == 0;
                    return if is_short && number <= max { Ok(number) } else { Err(wrong(name, number)) };
                }
            }
            Err(wrong(name, number))
        }

        fn header(&mut self, sensor: u32) -> Result<StripHeader, DatagramError> {
            let [_, kind, ..]: [u8; 4] = self.take()?;
            let has = |flag| kind & flag != 0;
            let (turn, first_column, columns) = (self.u16()?, self.u16()?, self.u16()?);
            let (time_us, first_tick) = (u32::from_le_bytes(self.take()?), self.u16()?);
            let strip = self.number("strip", u16::MAX.into())? as u16;
            let rate_q10 = self.number("ticks a column", RATE_MAX)?;
            let levels = self.number("step", u16::MAX.into())? as u16;
            let columns_a_turn =
                if has(ALIGNED_FLAG) { self.number("columns a turn", u16::MAX.into())? as u16 } else { 0 };
            let [noise, counts_a_level] = if has(SCALE_FLAG) { self.take()? } else { [USUAL_NOISE, 1] };
            let [id, stride] = if has(STREAM_FLAG) { self.take()? } else { [0, 1] };
            let step = if has(DEAD_ZONE_FLAG) { Step::new(levels) } else { Step::exact(levels) };
            let step =
                step.filter(|step| step.has_dead_zone() == has(DEAD_ZONE_FLAG)).ok_or(wrong("step", levels.into()))?;
            let predictor = if has(MEDIAN_EDGE_FLAG) { Predictor::MedianEdge } else { Predictor::West };
            for (name, field) in [("counts a level", counts_a_level), ("stride", stride)] {
                if field == 0 {
                    return Err(wrong(name, 0));
                }
            }
            if columns == 0 && !has(LAST_FLAG) {
                return Err(wrong("columns", 0));
            }
            Ok(StripHeader {
                last: has(LAST_FLAG),
                counts_a_level,
                sensor,
                id,
                turn,
                strip,
                first_column,
                columns,
                stride,
                time_us,
                first_tick,
                rate_q10,
                tier: kind & TIER_MASK,
                settings: ContextSettings { step, noise, predictor },
                columns_a_turn,
            })
        }
    }

    const fn wrong(name: &'static str, found: u32) -> DatagramError {
        DatagramError::Field { name, found }
    }
}
