//! `flicr view`: a picture of a scan and of what a frame keeps of it.

pub mod color;
mod range_panel;
mod top_panel;

use std::path::{Path, PathBuf};

use clap::Args;
use flicr::{Decoder, Header, Levels, Limits, Stamp};
use indicatif::ProgressBar;

use crate::args::{ColumnsArg, FrameArgs, Preset, word};
use crate::canvas::{Area, Canvas};
use crate::capture::CaptureArgs;
use crate::choice::ChoiceArgs;
use crate::codec::Codec;
use crate::failure::Failure;
use crate::frames::FrameFile;
use crate::input;
use crate::output::Outputs;
use crate::plan::{Noted, Plan};
use crate::table::grouped;
use color::HeightScale;

/// Write a PNG: the range image, and the original and decoded points from above
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct View {
    /// A .flicr file, or a scan (.bin, .xyzir.bin, .pcd; a turn of a .pcap) that is encoded as the options say
    input: PathBuf,
    /// The PNG
    #[arg(short, long)]
    output: PathBuf,
    /// Which frame of a .flicr file, from 0
    #[arg(long = "frame", value_name = "N", default_value_t = 0)]
    number: usize,
    #[command(flatten)]
    columns: ColumnsArg,
    #[command(flatten)]
    choice: ChoiceArgs,
    #[command(flatten)]
    frame: FrameArgs,
    #[command(flatten)]
    capture: CaptureArgs,
}

const EXAMPLES: &str = "\
The range image is stretched to the width of the picture: each of its pixels shows the nearest return of the
columns it stands for; black is no return. From above, x (ahead) is to the right, and color is height.

Examples:
  flicr view scan.bin -o scan.png --columns 512
  flicr view drive.flicr --frame 3 -o frame3.png";

/// What a picture shows.
struct Picture {
    title: String,
    header: Header,
    levels: Levels,
    original: Option<Vec<[f32; 3]>>,
    decoded: Vec<[f32; 3]>,
}

impl View {
    pub fn run(self) -> Result<(), Failure> {
        let holds_frames = input::holds_frames(&self.input)?;
        let picture = if holds_frames { self.of_frame()? } else { self.of_scan()? };
        let mut outputs = Outputs::new(std::slice::from_ref(&self.input));
        outputs.stage(&self.output, |temporary| {
            picture.draw().write_png(temporary).map_err(|error| Failure::data(&self.output, error))
        })?;
        outputs.commit()
    }

    fn of_frame(&self) -> Result<Picture, Failure> {
        let file = FrameFile::read_whole(&self.input)?;
        let bytes = file.frame(self.number)?;
        let title = format!("{}, frame {}", name(&self.input), self.number);
        Picture::new(&title, bytes, None).map_err(|error| file.damaged(self.number, error))
    }

    fn of_scan(&self) -> Result<Picture, Failure> {
        input::check_scan_extension(&self.input)?;
        let mut scans = input::scans(&self.input, &self.capture, self.frame.asked()?.as_ref())?;
        let scan = scans.next().unwrap_or_else(|| Ok(input::Scan::default()))?;
        let mut codec = Codec::new(&self.frame, self.choice.choice(), self.columns.columns)?;
        let wrong = |error| Failure::data(&self.input, error);
        let plan = codec.prepare(&scan).map_err(|error| Failure::data(&self.input, error))?;
        Noted::default().note(&ProgressBar::hidden(), &scan.name(&self.input), plan);
        let geometry = geometry(plan, self.frame.preset.as_ref());
        codec.encode(&scan, Stamp::default()).map_err(|error| Failure::data(&self.input, error))?;
        let title = format!("{}, {geometry}", scan.name(name(&self.input).as_ref()));
        Picture::new(&title, codec.frame(), Some(scan.returns())).map_err(wrong)
    }
}

fn geometry(plan: &Plan, preset: Option<&Preset>) -> String {
    match (preset, plan.shape.sensor()) {
        (Some(preset), _) => format!("preset {}", word(preset)),
        (None, Some(sensor)) => format!("{}, {}", sensor.grid().name, plan.shape.word()),
        (None, None) => plan.shape.word().to_owned(),
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

const WIDTH: u32 = 1600;
const MARGIN: u32 = 12;
/// Height of the text and the color bar above a panel.
const TITLE: u32 = 34;
const RANGE_HEIGHT: u32 = 256;
const TOP_HEIGHT: u32 = 780;

impl Picture {
    fn new(title: &str, frame: &[u8], original: Option<Vec<[f32; 3]>>) -> Result<Self, flicr::DecodeError> {
        let mut decoder = Decoder::new(Limits::default());
        let shown = decoder.decode(frame)?;
        let header = *shown.header();
        let coder = format!("{:?}", header.coder).to_lowercase();
        let title = format!(
            "{title}: {} x {}, {} bits, {coder}, {} bytes",
            header.columns,
            header.rows,
            header.quantizer.level_bits(),
            grouped(frame.len() as u64)
        );
        Ok(Self { title, header, levels: shown.levels().clone(), original, decoded: shown.points() })
    }

    fn draw(&self) -> Canvas {
        let range_top = MARGIN + TITLE;
        let top_top = range_top + RANGE_HEIGHT + MARGIN + TITLE;
        let mut canvas = Canvas::new(WIDTH, top_top + TOP_HEIGHT + MARGIN);
        canvas.text(MARGIN, MARGIN, &self.title);
        let range_area = Area { x: MARGIN, y: range_top, width: WIDTH - 2 * MARGIN, height: RANGE_HEIGHT };
        range_panel::draw(&mut canvas, range_area, &self.header, &self.levels);
        color::range_legend(&mut canvas, WIDTH - MARGIN, MARGIN);
        self.draw_top_views(&mut canvas, Area { y: top_top, height: TOP_HEIGHT, ..range_area });
        canvas
    }

    fn draw_top_views(&self, canvas: &mut Canvas, area: Area) {
        let shown = self.original.as_ref().unwrap_or(&self.decoded);
        let heights = HeightScale::of(shown);
        let radius_m = top_panel::radius_m(shown);
        let decoded = format!("decoded: {} points", grouped(self.decoded.len() as u64));
        let mut draw = |area: Area, points: &[[f32; 3]], label: &str| {
            canvas.text(area.x, area.y - TITLE, label);
            top_panel::draw(canvas, area, points, heights, radius_m);
        };
        if let Some(original) = &self.original {
            let [left, right] = area.halves(MARGIN);
            draw(left, original, &format!("original: {} returns", grouped(original.len() as u64)));
            draw(right, &self.decoded, &decoded);
        } else {
            draw(area, &self.decoded, &decoded);
        }
        heights.legend(canvas, area.x + area.width, area.y - TITLE);
    }
}
