//! The command line keeps its promises: every subcommand on simulated scans, exit codes, and what is left behind.

#[path = "cli/bad_input.rs"]
mod bad_input;
#[path = "cli/calibrate.rs"]
mod calibrate;
#[path = "common/capture_writer.rs"]
mod capture_writer;
#[path = "cli/captures.rs"]
mod captures;
#[path = "cli/choices.rs"]
mod choices;
#[path = "cli/compare.rs"]
mod compare;
#[path = "cli/eval.rs"]
mod eval;
#[path = "cli/exact.rs"]
mod exact;
#[path = "common/packet_writer.rs"]
mod packet_writer;
#[path = "cli/picture.rs"]
mod picture;
#[path = "cli/previous.rs"]
mod previous;
#[path = "cli/receive.rs"]
mod receive;
#[path = "cli/round_trip.rs"]
mod round_trip;
#[path = "cli/run.rs"]
mod run;
#[path = "cli/sensors.rs"]
mod sensors;
#[path = "cli/terminal.rs"]
mod terminal;
#[path = "cli/view.rs"]
mod view;
