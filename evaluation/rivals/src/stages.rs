//! What each stage of flicr takes, by frame: `paper|uniform:COLUMNS:deflate|rle` (8 bits), `native:dense|small|fast:COUNTS` (the
//! sensor's firings, steps of so many counts of 2 mm).

use std::error::Error;

use flicr::coder::{Coder, ContextSettings, Fast, Step};
use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::{
    Config, Decoder, DeflateDefault, Dense, EncodeError, Encoded, FrameEncoder, ImageViewMut, LatticeConfig, Level,
    Limits, Rle, Scale, Settings, Small, Stamp,
};
use serde_json::{Value, json};

use crate::Outcome;
use crate::codec::report;
use crate::cost::{Cost, measure};

/// Bytes and times, and the points that came back.
type Made = Result<(Value, Vec<[f32; 3]>), Box<dyn Error>>;

pub fn run(frame: &str, scan: &[[f32; 4]], runs: usize) -> Outcome {
    let words: Vec<&str> = frame.split(':').collect();
    match *words.as_slice() {
        ["paper", columns, coder] => evenly(&Config::PAPER, columns.parse()?, coder, scan, runs),
        ["uniform", columns, coder] => evenly(&Config::UNIFORM, columns.parse()?, coder, scan, runs),
        ["native", tier, counts] => native(tier, counts.parse()?, scan, runs),
        _ => Err(format!("no frame {frame}").into()),
    }
}

/// In evenly spread rows and columns, scaled to the farthest point as the command line does.
fn evenly(preset: &Config, columns: usize, coder: &str, scan: &[[f32; 4]], runs: usize) -> Outcome {
    let range_m = |[x, y, z, _]: &[f32; 4]| (x * x + y * y + z * z).sqrt();
    let (max_range_m, farthest) = measure(runs, || scan.iter().map(range_m).fold(1.0, f32::max));
    let config = Config { scale: Scale::Fixed { max_range_m }, ..*preset };
    let mut levels = vec![0_u8; 64 * columns];
    evenly_coded(&config, coder, ("scale", farthest), (&mut levels, columns), scan, runs)
}

fn evenly_coded(
    config: &Config,
    coder: &str,
    first: (&str, Cost),
    image: (&mut [u8], usize),
    scan: &[[f32; 4]],
    runs: usize,
) -> Outcome {
    match coder {
        "rle" => stages(config, &mut Rle::new(), Some(first), image, scan, runs, |frame, out| frame.finish(out)),
        _ => stages(config, &mut *Box::new(DeflateDefault::new()), Some(first), image, scan, runs, |frame, out| {
            frame.finish(out)
        }),
    }
    .map(|(made, _)| made)
}

fn native(tier: &str, counts: u16, scan: &[[f32; 4]], runs: usize) -> Outcome {
    let settings = settings(counts)?;
    match tier {
        "small" => by_firings(&mut Small::<8>::new(settings), scan, runs),
        "dense" => by_firings(&mut Dense::<8>::new(settings), scan, runs),
        _ => by_firings(&mut *Box::new(Fast::<1>::new(settings)), scan, runs),
    }
    .map(|(made, _)| made)
}

/// The length of a frame of the sensor's firings, and the points that come back.
pub fn there_and_back(tier: &str, counts: u16, scan: &[[f32; 4]]) -> Result<(usize, Vec<[f32; 3]>), Box<dyn Error>> {
    let settings = settings(counts)?;
    let (made, points) = match tier {
        "dense" => by_firings(&mut Dense::<8>::new(settings), scan, 1),
        _ => by_firings(&mut *Box::new(Fast::<1>::new(settings)), scan, 1),
    }?;
    Ok((made["bytes"].as_u64().ok_or("no length")? as usize, points))
}

fn settings(counts: u16) -> Result<ContextSettings, Box<dyn Error>> {
    Ok(ContextSettings::FINE.with_step(Step::new(counts).ok_or("a step of no counts")?))
}

fn by_firings<C: Coder<u16>>(coder: &mut C, scan: &[[f32; 4]], runs: usize) -> Made {
    let grid = hdl64e::FIRING_GRID;
    let lattice = Lattice::<66>::new(grid, grid.ticks as usize)?;
    let config = LatticeConfig::new(&lattice);
    let columns = grid.ticks as usize;
    let mut levels = vec![0_u16; grid.beams.len() * columns];
    stages(&config, coder, None, (&mut levels, columns), scan, runs, |frame, out| frame.finish_by_firings::<125>(out))
}

/// Projection is timed alone; coding is what the whole takes more. Before both may come a pass over the points, by name.
fn stages<L: Level, C: Coder<L>, S: Settings>(
    config: &S,
    coder: &mut C,
    first: Option<(&str, Cost)>,
    (levels, columns): (&mut [L], usize),
    scan: &[[f32; 4]],
    runs: usize,
    finish: fn(FrameEncoder<'_, L, C, S>, &mut [u8]) -> Result<Encoded, EncodeError>,
) -> Made {
    let (outcome, project) = measure(runs, || -> Result<(), Box<dyn Error>> {
        let image = ImageViewMut::new(levels, columns).ok_or("no image")?;
        FrameEncoder::start(config, Stamp::default(), image, coder)?.insert(scan);
        Ok(())
    });
    outcome?;
    let mut out = vec![0; 2_000_000];
    let (encoded, encode) = measure(runs, || -> Result<usize, Box<dyn Error>> {
        let image = ImageViewMut::new(levels, columns).ok_or("no image")?;
        let mut frame = FrameEncoder::start(config, Stamp::default(), image, coder)?;
        frame.insert(scan);
        Ok(finish(frame, &mut out)?.len)
    });
    let len = encoded?;
    let mut decoder = Decoder::new(Limits::default());
    let (outcome, uncode) = measure(runs, || decoder.decode(&out[..len]).map(|_| ()));
    outcome?;
    let mut points = Vec::new();
    let (outcome, decode) = measure(runs, || decoder.decode(&out[..len]).map(|frame| frame.points_into(&mut points)));
    outcome?;
    let whole = first.map_or(encode, |(_, first)| first.and(encode));
    let mut made = report(len, whole, decode);
    made["stages"] = json!({
        "project": project.json(), "code": encode.beyond(project).json(),
        "uncode": uncode.json(), "points": decode.beyond(uncode).json(),
    });
    if let Some((name, cost)) = first {
        made["stages"][name] = cost.json();
    }
    Ok((made, points))
}
