//! `flicr`: encodes, decodes, measures and shows LiDAR scans. One file a subcommand.
#![forbid(unsafe_code)]

mod args;
mod calibrate;
mod canvas;
mod capture;
mod choice;
mod codec;
mod compare;
mod console;
mod decode;
mod encode;
mod eval;
mod failure;
mod frames;
mod info;
mod input;
mod output;
mod plan;
mod receive;
mod sensors;
mod simulate;
mod table;
mod view;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    match args::Cli::parse().command.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
