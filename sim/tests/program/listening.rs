//! Who listens: nobody.
//!
//! Goal: no command opens a door that was not requested. Setup: sockets of the process and its threads, as the
//! system lists them, listed again and again while it works.

use std::collections::HashSet;
use std::fs;
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::Duration;

use crate::work::{WORK, bench};

/// Local addresses, as `/proc/net/tcp` writes them, on which a process listens; those of UDP are open at once.
fn doors(process: u32) -> Vec<String> {
    let links = fs::read_dir(format!("/proc/{process}/fd")).into_iter().flatten().flatten();
    let of_socket = |link: fs::DirEntry| {
        let to = fs::read_link(link.path()).ok()?.into_os_string().into_string().ok()?;
        Some(to.strip_prefix("socket:[")?.strip_suffix(']')?.to_owned())
    };
    let sockets: HashSet<String> = links.filter_map(of_socket).collect();
    let mut found = Vec::new();
    for table in ["tcp", "tcp6", "udp", "udp6"] {
        let text = fs::read_to_string(format!("/proc/{process}/net/{table}")).unwrap_or_default();
        for line in text.lines().skip(1) {
            let cells: Vec<&str> = line.split_whitespace().collect();
            let is_open = table.starts_with("udp") || cells[3] == "0A";
            if is_open && sockets.contains(cells[9]) {
                found.push(format!("{table} {}", cells[1]));
            }
        }
    }
    found
}

/// Doors of a process until it ends.
fn watched(child: &mut Child) -> Vec<String> {
    let mut found = Vec::new();
    while child.try_wait().expect("a child").is_none() {
        found.extend(doors(child.id()));
        sleep(Duration::from_millis(1));
    }
    found
}

#[test]
fn the_list_shows_who_listens() {
    let listener = std::net::TcpListener::bind(("127.0.0.1", 0)).expect("a free port");
    let port = listener.local_addr().expect("an address").port();
    assert!(doors(std::process::id()).contains(&format!("tcp 0100007F:{port:04X}")));
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn no_command_listens() {
    let bench = bench("listening");
    for (kind, work) in WORK.iter().enumerate() {
        let out = format!("out-{kind}{}", work.ending);
        let mut command = bench.command(&[work.arguments, &["-q", "--out", &out]].concat());
        let mut child = command.stdout(Stdio::null()).spawn().expect("efam runs");
        assert_eq!(watched(&mut child), [""; 0], "{}", work.arguments.join(" "));
        assert!(child.wait().is_ok_and(|status| status.success()));
    }
}

/// What `serve` opens is seen from this machine alone.
#[test]
#[cfg(feature = "rerun")]
fn efam_serves_this_machine_alone() {
    use std::time::Instant;

    use efam::observe::rerun::DEFAULT_PORT;

    let bench = crate::bench::Bench::new("served");
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/release-15psi.toml");
    let mut command = bench.command(&["simulate", scenario, "-q", "--watch-only", "--rerun", "serve"]);
    let mut child = command.stderr(Stdio::null()).spawn().unwrap();
    // It serves until it is interrupted.
    let begin = Instant::now();
    let mut found = Vec::new();
    while !found.iter().any(|door: &String| door.ends_with(&format!(":{DEFAULT_PORT:04X}"))) {
        assert!(begin.elapsed() < Duration::from_secs(60), "nothing is served: {found:?}");
        assert!(child.try_wait().unwrap().is_none(), "it did not wait for viewers");
        found = doors(child.id());
        sleep(Duration::from_millis(5));
    }
    sleep(Duration::from_millis(500));
    found.extend(doors(child.id()));
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(found.iter().all(|door| door.starts_with("tcp 0100007F:")), "{found:?}");
    assert!(bench.left().is_empty(), "{:?}", bench.left());
}
