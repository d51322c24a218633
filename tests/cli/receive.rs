//! `flicr receive`: what a link lost is lost, what it doubled is not, and everything is told.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, UdpSocket};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use flicr::coder::{ContextSettings, SmallModel, Step};
use flicr::geometry::sensors::hdl64e;
use flicr::simulate::Simulator;
use flicr::stream::{StreamConfig, StreamDecoder, StreamEncoder, write_framed};

use super::run::{Place, points};

/// Three turns, each its datagrams.
fn turns() -> Vec<Vec<Vec<u8>>> {
    let settings = ContextSettings::FINE.with_step(Step::new(51).unwrap());
    let config = StreamConfig::new(&hdl64e::FIRING_GRID, 1, settings).unwrap();
    let mut stream: StreamEncoder<SmallModel> = StreamEncoder::new(config).unwrap();
    let turns = Simulator::hdl64e(4).take(3).map(|turn| {
        let mut sent = Vec::new();
        let mut firings = vec![[0; 64]; turn.firing_ticks.len()];
        for found in &turn.returns {
            firings[usize::from(found.firing)][usize::from(found.beam)] = found.count;
        }
        for (index, (counts, &tick)) in (0..).zip(firings.iter().zip(&turn.firing_ticks)) {
            stream.push_counts(index, tick, turn.time_ns, counts, |datagram| sent.push(datagram.to_vec()));
        }
        stream.end_turn(|datagram| sent.push(datagram.to_vec()));
        sent
    });
    turns.collect()
}

fn start(place: &Place, args: &[&str]) -> Child {
    std::fs::create_dir(place.path("turns")).unwrap();
    Command::new(env!("CARGO_BIN_EXE_flicr"))
        .args(["receive", "-o", "turns", "--format", "bin"])
        .args(args)
        .current_dir(place.folder())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// The lines on turns, and the summary.
fn end(mut child: Child) -> (Vec<String>, String) {
    let (mut stdout, mut stderr) = (String::new(), String::new());
    child.stdout.take().unwrap().read_to_string(&mut stdout).unwrap();
    if let Some(mut left) = child.stderr.take() {
        left.read_to_string(&mut stderr).unwrap();
    }
    assert!(child.wait().unwrap().success(), "{stderr}");
    assert!(!stdout.contains('\u{1b}'));
    (stdout.lines().map(str::to_owned).collect(), stderr)
}

/// The files are what a decoder makes of these datagrams.
fn check_files(place: &Place, datagrams: &[Vec<u8>]) {
    let mut decoder = StreamDecoder::default();
    let mut expected = Vec::new();
    for datagram in datagrams {
        let _ = decoder.push(datagram);
        expected.extend(std::iter::from_fn(|| decoder.next_turn()));
    }
    decoder.flush();
    expected.extend(std::iter::from_fn(|| decoder.next_turn()));
    assert_eq!(expected.len(), 3);
    for (number, turn) in expected.iter().enumerate() {
        let found: Vec<_> =
            points(&place.read(&format!("turns/{number:06}.bin"))).iter().map(|&[x, y, z, _]| [x, y, z]).collect();
        assert!(found.len() > 50_000);
        assert_eq!(found, turn.points(), "turn {number}");
    }
}

#[test]
fn datagrams_are_lost_and_doubled() {
    let place = Place::new();
    let mut child = start(&place, &["udp://127.0.0.1:0", "--idle", "1.5", "--sensor", "auto"]);
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut listening = String::new();
    stderr.read_line(&mut listening).unwrap();
    let address = listening.trim().strip_prefix("note: listening at ").unwrap_or_else(|| panic!("{listening}"));
    let mut turns = turns();
    let lost = turns[1].remove(5);
    assert!(lost.len() > 1000);
    turns[2].swap(3, 4);
    let again = turns[2][7].clone();
    turns[2].insert(9, again);
    turns[0].insert(2, vec![1; 100]);
    let sent = turns.concat();
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    for datagram in &sent {
        socket.send_to(datagram, address).unwrap();
        std::thread::sleep(Duration::from_millis(2));
    }
    let (lines, _) = end(child);
    let mut summary = String::new();
    stderr.read_to_string(&mut summary).unwrap();
    assert_eq!(lines.len(), 3, "{lines:?} {summary}");
    let is_complete = lines.iter().map(|line| line.ends_with(", complete")).collect::<Vec<_>>();
    assert_eq!(is_complete, [true, false, true], "{lines:?}");
    assert!(lines[1].contains("incomplete: 1 strips missing"), "{lines:?}");
    for words in [" KB/s", " datagrams/s", " turns/s", "latency ", " columns (worst "] {
        assert!(lines.iter().all(|line| line.contains(words)), "{lines:?}");
    }
    assert!(summary.contains("1 strips missing in 1 turns, 2 datagrams refused"), "{summary}");
    check_files(&place, &sent);
}

/// Over a byte stream, with noise between: by stdin and from a server.
#[test]
fn byte_streams_are_framed() {
    let sent = turns().concat();
    let mut line = vec![7; 50];
    for datagram in &sent {
        write_framed(&mut line, datagram).unwrap();
    }
    let check = |place: &Place, (lines, summary): (Vec<String>, String)| {
        assert!(lines.len() == 3 && lines.iter().all(|line| line.ends_with(", complete")), "{lines:?}");
        assert!(summary.contains("3 turns") && summary.contains("1 frames torn"), "{summary}");
        check_files(place, &sent);
    };
    let place = Place::new();
    let mut child = start(&place, &["-"]);
    child.stdin.take().unwrap().write_all(&line).unwrap();
    check(&place, end(child));

    let place = Place::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let child = start(&place, &[&format!("tcp:{}", listener.local_addr().unwrap()), "--turns", "3"]);
    let (mut client, _) = listener.accept().unwrap();
    client.write_all(&line).unwrap();
    check(&place, end(child));
}

/// Ctrl-C ends it as its source's end does.
#[cfg(unix)]
#[test]
fn it_ends_cleanly() {
    let place = Place::new();
    let mut child = start(&place, &["-", "--idle", "0"]);
    let mut line = Vec::new();
    turns()[0].iter().for_each(|datagram| write_framed(&mut line, datagram).unwrap());
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(&line).unwrap();
    // Until the turn was written it may not be there to be interrupted.
    while !place.path("turns/000000.bin").exists() {
        std::thread::sleep(Duration::from_millis(20));
    }
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let (lines, summary) = end(child);
    assert!(lines.len() == 1 && summary.contains("1 turns"), "{lines:?} {summary}");
    drop(stdin);
}

#[test]
fn what_cannot_be_received_is_refused() {
    let place = Place::new();
    place.fails_with(2, &["receive", "-", "-o", "nowhere"], "nowhere", &["a folder"]);
    place.fails_with(2, &["receive", "-", "--sensor", "eye"], "eye", &["no such sensor"]);
    place.fails_with(1, &["receive", "no-such-device"], "no-such-device", &["No such file"]);
}

/// On a terminal there is a picture, and the cursor comes back.
#[cfg(target_os = "linux")]
#[test]
fn a_picture_where_a_terminal_watches() {
    let place = Place::new();
    let mut line = Vec::new();
    turns()[0].iter().for_each(|datagram| write_framed(&mut line, datagram).unwrap());
    place.write("stream", &line);
    let command = format!("{} receive stream", env!("CARGO_BIN_EXE_flicr"));
    let on_terminal = Command::new("script")
        .args(["-qec", &command, "/dev/null"])
        .env("TERM", "xterm")
        .current_dir(place.folder())
        .stdin(Stdio::null())
        .output();
    let output = on_terminal.expect("`script`, which every Linux has, to make a terminal with");
    let seen = String::from_utf8_lossy(&output.stdout);
    assert!(seen.contains('\u{2580}') && seen.contains(" KB/s"), "{seen:?}");
    assert!(seen.contains("\u{1b}[?25h"));
}
