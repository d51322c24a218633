//! The smallest firmware that encodes, and the same without the codec: what lies between them is the codec's flash.
//!
//! `tools/size.sh` builds it for each kind of encoder (`--cfg footprint="..."`), and once without any. It is never run.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod firmware {
    use core::panic::PanicInfo;

    #[cfg(any(footprint = "stream:vlp16", footprint = "stream:hdl64e", footprint = "stream:aligned"))]
    mod codec {
        use core::hint::black_box;

        use flicr::coder::{ContextSettings, SmallModel};
        use flicr::stream::{DATAGRAM_LEN, StreamConfig, StreamEncoder};
        use static_cell::ConstStaticCell;

        /// Packets of 16 beams, as fired.
        #[cfg(footprint = "stream:vlp16")]
        mod kind {
            use flicr::geometry::sensors::velodyne;
            use flicr::geometry::{Beam, SensorGrid};
            use flicr::packet::{Model, ReturnPolicy, Sensor, TurnAssembler};
            use static_cell::ConstStaticCell;

            use super::{Stream, take_all};

            pub type Line = flicr::stream::AsFired;
            pub const GROUPS: usize = 2;
            static BEAMS: [Beam; 16] = velodyne::VLP16.beams_at(600).expect("16 beams");
            pub static GRID: SensorGrid<'static> = velodyne::VLP16.grid_of(&BEAMS);
            static TURNS: ConstStaticCell<TurnAssembler> =
                ConstStaticCell::new(TurnAssembler::new(Sensor::Spinning(Model::Vlp16), ReturnPolicy::Strongest));

            pub fn push(stream: &mut Stream, bytes: &[u8]) {
                let Some(turns) = TURNS.try_take() else { return };
                let _ = turns.push(bytes, |event| {
                    stream.feed(&event);
                    take_all(stream);
                });
                turns.finish(|event| {
                    stream.feed(&event);
                    take_all(stream);
                });
            }
        }
        /// Columns of 64 beams, as fired.
        #[cfg(footprint = "stream:hdl64e")]
        mod kind {
            pub use super::columns::push;
            pub use flicr::geometry::sensors::hdl64e::FIRING_GRID as GRID;
            pub type Line = flicr::stream::AsFired;
            pub const GROUPS: usize = 8;
        }
        /// Columns of 64 beams, aligned.
        #[cfg(footprint = "stream:aligned")]
        mod kind {
            pub use super::columns::push;
            pub use flicr::geometry::sensors::hdl64e::FIRING_GRID as GRID;
            pub type Line = flicr::stream::AlignedHdl64e;
            pub const GROUPS: usize = 8;
        }

        #[cfg(not(footprint = "stream:vlp16"))]
        mod columns {
            use core::hint::black_box;

            use super::{Stream, take_all};

            pub fn push(stream: &mut Stream, bytes: &[u8]) {
                let counts = black_box([0; 64]);
                stream.feed_counts(bytes.len() as u16, black_box(0), 0, &counts);
                take_all(stream);
                stream.feed_turn_end();
                take_all(stream);
                stream.feed_finish();
            }
        }

        type Stream = StreamEncoder<SmallModel, { kind::GROUPS }, DATAGRAM_LEN, kind::Line>;
        static STREAM: ConstStaticCell<Stream> = ConstStaticCell::new(Stream::BLANK);

        fn take_all(stream: &mut Stream) {
            while let Some(datagram) = stream.next_datagram() {
                black_box(datagram.len());
            }
        }

        /// Datagrams' bytes, 0 where there are none.
        pub fn encode() -> usize {
            let Some(stream) = STREAM.try_take() else { return 0 };
            let Ok(config) = StreamConfig::new(&kind::GRID, 1, black_box(ContextSettings::FINE)) else { return 0 };
            if stream.start(StreamConfig { columns_a_turn: 2150, ..config }).is_err() {
                return 0;
            }
            kind::push(stream, black_box(&[]));
            take_all(stream);
            stream.tally().bytes as usize
        }
    }

    #[cfg(all(
        footprint,
        not(any(footprint = "stream:vlp16", footprint = "stream:hdl64e", footprint = "stream:aligned"))
    ))]
    mod codec {
        use flicr::{Config, Encoder, Scale, Stamp, StridedPoints};
        use static_cell::ConstStaticCell;

        #[cfg(footprint = "4500:store")]
        mod kind {
            pub type Coder = flicr::Store;
            pub const COLUMNS: usize = 4500;
            pub const CODER: Coder = Coder::new();
        }
        #[cfg(footprint = "4500:rle")]
        mod kind {
            pub type Coder = flicr::Rle;
            pub const COLUMNS: usize = 4500;
            pub const CODER: Coder = Coder::new();
        }
        #[cfg(footprint = "256:rle")]
        mod kind {
            pub type Coder = flicr::Rle;
            pub const COLUMNS: usize = 256;
            pub const CODER: Coder = Coder::new();
        }

        #[cfg(footprint = "4500:deflate")]
        mod kind {
            pub type Coder = flicr::DeflateDefault;
            pub const COLUMNS: usize = 4500;
            pub const CODER: Coder = Coder::new();
        }
        #[cfg(footprint = "256:deflate-small")]
        mod kind {
            pub type Coder = flicr::DeflateSmall;
            pub const COLUMNS: usize = 256;
            pub const CODER: Coder = Coder::new();
        }
        #[cfg(footprint = "4500:deflate-small")]
        mod kind {
            pub type Coder = flicr::DeflateSmall;
            pub const COLUMNS: usize = 4500;
            pub const CODER: Coder = Coder::new();
        }

        #[cfg(footprint = "4500:small")]
        mod kind {
            use flicr::coder::ContextSettings;
            pub type Coder = flicr::Small;
            pub const COLUMNS: usize = 4500;
            pub const CODER: Coder = Coder::new(ContextSettings::COARSE);
        }
        #[cfg(footprint = "4500:dense")]
        mod kind {
            use flicr::coder::ContextSettings;
            pub type Coder = flicr::Dense;
            pub const COLUMNS: usize = 4500;
            pub const CODER: Coder = Coder::new(ContextSettings::COARSE);
        }

        use kind::{CODER, COLUMNS, Coder};

        type FrameEncoder = Encoder<64, COLUMNS, u8, Coder>;
        type Out = [u8; FrameEncoder::WORST_CASE_LEN];

        static CONFIG: Config = Config { scale: Scale::Fixed { max_range_m: 120.0 }, ..Config::UNIFORM };
        // Unmangled, so that `tools/size.sh` finds them: their sizes are the RAM that the codec takes.
        #[allow(unsafe_code, reason = "a name for the linker")]
        #[unsafe(no_mangle)]
        static ENCODER: ConstStaticCell<FrameEncoder> = ConstStaticCell::new(FrameEncoder::new(CODER));
        #[allow(unsafe_code, reason = "a name for the linker")]
        #[unsafe(no_mangle)]
        static OUT: ConstStaticCell<Out> = ConstStaticCell::new([0; FrameEncoder::WORST_CASE_LEN]);
        /// The frame's length, 0 where there is none.
        pub fn encode() -> usize {
            let (Some(encoder), Some(out), Some(points)) = (ENCODER.try_take(), OUT.try_take(), scan()) else {
                return 0;
            };
            encoder.encode(&CONFIG, &points, Stamp::default(), out).map_or(0, |encoded| encoded.len)
        }

        /// No points, but the compiler cannot know that.
        fn scan() -> Option<StridedPoints<'static>> {
            StridedPoints::new(core::hint::black_box(&[]), 16)
        }
    }

    #[cfg(not(footprint))]
    mod codec {
        pub fn encode() -> usize {
            0
        }
    }

    fn run() -> ! {
        // The result is used, as far as the compiler can know.
        core::hint::black_box(codec::encode());
        loop {
            core::hint::spin_loop();
        }
    }

    #[cfg(target_arch = "arm")]
    #[cortex_m_rt::entry]
    fn main() -> ! {
        run()
    }

    // It need not start: it is never run.
    #[cfg(target_arch = "aarch64")]
    core::arch::global_asm!(
        ".pushsection .text.start, \"ax\"",
        ".global _start",
        "_start: b {run}",
        ".popsection",
        run = sym run,
    );

    #[panic_handler]
    fn panic(_: &PanicInfo<'_>) -> ! {
        loop {
            core::hint::spin_loop();
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: see the comment at its top");
    std::process::exit(2);
}
