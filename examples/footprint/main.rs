//! The smallest firmware that encodes, and the same without the codec: what lies between them is the codec's flash.
//!
//! `tools/size.sh` builds it for each kind of encoder (`--cfg footprint="..."`), and once without any. It is never run.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod firmware {
    use core::panic::PanicInfo;

    #[cfg(footprint)]
    mod codec {
        use flicr::{Config, Encoder, Scale, Stamp, StridedPoints};
        use static_cell::ConstStaticCell;

        #[cfg(footprint = "4500:rle")]
        mod kind {
            pub type Coder = flicr::Rle;
            pub const COLUMNS: usize = 4500;
        }
        #[cfg(footprint = "256:rle")]
        mod kind {
            pub type Coder = flicr::Rle;
            pub const COLUMNS: usize = 256;
        }

        #[cfg(footprint = "4500:deflate")]
        mod kind {
            pub type Coder = flicr::DeflateDefault;
            pub const COLUMNS: usize = 4500;
        }
        #[cfg(footprint = "256:deflate-small")]
        mod kind {
            pub type Coder = flicr::DeflateSmall;
            pub const COLUMNS: usize = 256;
        }
        #[cfg(footprint = "4500:deflate-small")]
        mod kind {
            pub type Coder = flicr::DeflateSmall;
            pub const COLUMNS: usize = 4500;
        }

        use kind::{COLUMNS, Coder};

        type FrameEncoder = Encoder<64, COLUMNS, u8, Coder>;
        type Out = [u8; FrameEncoder::WORST_CASE_LEN];

        static CONFIG: Config = Config { scale: Scale::Fixed { max_range_m: 120.0 }, ..Config::UNIFORM };
        // Unmangled, so that `tools/size.sh` finds them: their sizes are the RAM that the codec takes.
        #[allow(unsafe_code, reason = "a name for the linker")]
        #[unsafe(no_mangle)]
        static ENCODER: ConstStaticCell<FrameEncoder> = ConstStaticCell::new(FrameEncoder::new(Coder::new()));
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

    #[cortex_m_rt::entry]
    fn main() -> ! {
        // The result is used, as far as the compiler can know.
        core::hint::black_box(codec::encode());
        loop {
            cortex_m::asm::wfi();
        }
    }

    #[panic_handler]
    fn panic(_: &PanicInfo<'_>) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: see the comment at its top");
    std::process::exit(2);
}
