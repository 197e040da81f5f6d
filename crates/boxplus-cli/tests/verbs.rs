//! Every verb, every exit code, every stream.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Command, Stdio};
use std::time::Duration;

use common::{Folder, SQUARE, settings};

fn square() -> Folder {
    Folder::new().with("map.g2o", SQUARE)
}

#[test]
fn solve_prints_one_readable_screen() {
    let run = square().boxplus("solve map.g2o --threads 1");
    assert_eq!(run.code, 0);
    settings().bind(|| insta::assert_snapshot!(run.transcript()));
}

#[test]
fn solve_tells_every_step_when_asked() {
    let run = square().boxplus("solve map.g2o --threads 1 --verbose --init file --algorithm dogleg");
    assert_eq!(run.code, 0);
    assert!(run.stdout.contains("step   cost"), "{}", run.stdout);
    assert!(run.stdout.lines().count() > 16, "{}", run.stdout);
}

#[test]
fn the_json_of_solve_has_every_promised_field() {
    let folder = square();
    let run = folder.boxplus("solve map.g2o --json --threads 1 -o out.g2o --plot out.svg --covariance");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let document = run.json();
    for field in [
        "format",
        "version",
        "input",
        "vertices",
        "edges",
        "initial_cost",
        "cost",
        "costs",
        "iterations",
        "termination",
        "converged",
        "seconds",
        "threads",
        "trace",
        "gauge",
        "initialisation",
        "worst_edges",
        "faults",
        "outputs",
    ] {
        assert!(document.get(field).is_some(), "{field} is missing: {document}");
    }
    for cost in ["log", "g2o", "se_sync", "ceres"] {
        assert!(document["costs"][cost].as_f64().unwrap() > 0.0, "{cost}");
    }
    for phase in ["load", "initialise", "optimise", "total"] {
        assert!(document["seconds"][phase].as_f64().unwrap() >= 0.0, "{phase}");
    }
    let trace = document["trace"].as_array().unwrap();
    assert_eq!(trace.len() as u64, document["iterations"].as_u64().unwrap());
    assert!(trace.iter().all(|step| step["cost"].is_f64() && step["seconds"].is_f64()));
    assert_eq!(document["worst_edges"][0]["line"].as_u64().map(|line| (5..9).contains(&line)), Some(true));
    assert_eq!(document["outputs"], serde_json::json!(["out.g2o", "out.svg"]));
    assert!(run.stderr.contains("wrote out.g2o"), "{}", run.stderr);
}

/// A ring of 20 poses whose vertices turn twice where the measurements turn once.
fn twisted_ring() -> String {
    let turn = std::f64::consts::TAU / 20.0;
    let vertex = |i: usize| format!("VERTEX_SE2 {i} 0 0 {}\n", 2.0 * turn * i as f64);
    let edge = |i: usize| format!("EDGE_SE2 {i} {} 0 0 {turn} 1 0 0 1 0 1\n", (i + 1) % 20);
    (0..20).map(vertex).chain((0..20).map(edge)).collect()
}

#[test]
fn certify_proves_an_optimum_and_leaves_a_local_minimum() {
    let folder = square().with("ring.g2o", twisted_ring());
    let proved = folder.boxplus("solve map.g2o --certify --json").json();
    assert_eq!(proved["certificate"]["verdict"], "optimal", "{proved}");
    assert_eq!(proved["certificate"]["descent"], serde_json::Value::Null);
    let stuck = folder.boxplus("solve ring.g2o --init file --json").json();
    assert!(stuck["cost"].as_f64().unwrap() > 0.9 && stuck["certificate"].is_null(), "{stuck}");
    let run = folder.boxplus("solve ring.g2o --init file --certify --json -o out.g2o");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let freed = run.json();
    assert_eq!(freed["certificate"]["escapes"], 1, "{freed}");
    assert!(
        freed["cost"].as_f64().unwrap() < 1e-20 && freed["initial_cost"].as_f64().unwrap() > 0.9,
        "{freed}"
    );
    let screen = folder.boxplus("solve ring.g2o --init file --certify");
    assert!(
        screen.stdout.contains("optimum   yes") && screen.stdout.contains("turn most"),
        "{}",
        screen.stdout
    );
}

#[test]
fn certify_refuses_what_its_proof_does_not_cover() {
    let folder = square();
    let run = folder.boxplus("solve demo:landmarks --size 60 --certify");
    assert!(run.code == 2 && run.stderr.contains("EDGE_SE2_XY"), "{}", run.stderr);
    assert_eq!(folder.boxplus("solve map.g2o --certify --robust huber").code, 2);
}

#[test]
fn the_solved_file_starts_at_the_optimum() {
    let folder = square();
    let first = folder.boxplus("solve map.g2o --json -o out.g2o").json();
    let again = folder.boxplus("solve out.g2o --json --init file").json();
    let (cost, start) = (first["cost"].as_f64().unwrap(), again["given_cost"].as_f64().unwrap());
    assert!((cost - start).abs() <= 1e-9 * cost, "{cost} {start}");
}

#[test]
fn each_chart_minimises_its_own_cost() {
    let folder = Folder::new();
    folder.boxplus("simulate grid --size 60 --seed 3 --noise 3 -o map.g2o");
    let charts = [("log", "log"), ("g2o", "g2o"), ("ceres", "ceres"), ("se-sync", "se_sync")];
    let documents =
        charts.map(|(chart, _)| folder.boxplus(&format!("solve map.g2o --json --chart {chart}")).json());
    for (i, (chart, field)) in charts.iter().enumerate() {
        let own = documents[i]["costs"][field].as_f64().unwrap();
        assert!((documents[i]["cost"].as_f64().unwrap() - own).abs() <= 1e-9 * own, "{chart}");
        for other in &documents {
            assert!(other["costs"][field].as_f64().unwrap() >= own * (1.0 - 1e-9), "{chart}");
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_digit() {
    let folder = Folder::new();
    folder.boxplus("simulate sphere --size 400 --seed 5 -o map.g2o");
    folder.boxplus("solve map.g2o -q --threads 1 -o one.g2o");
    folder.boxplus("solve map.g2o -q --threads 3 -o three.g2o");
    assert_eq!(folder.read("one.g2o"), folder.read("three.g2o"));
}

#[test]
fn a_fixed_vertex_does_not_move_by_a_bit() {
    let folder = square();
    let document = folder.boxplus("solve map.g2o --fix 2 --json -o out.g2o").json();
    assert_eq!(document["gauge"], serde_json::json!({"fixed": [2], "held": []}));
    let out = String::from_utf8(folder.read("out.g2o")).unwrap();
    assert!(out.contains("VERTEX_SE2 2 1 1.2 3.1\n"), "{out}");
}

#[test]
fn a_robust_kernel_bears_wrong_loop_closures() {
    let folder = Folder::new();
    folder.boxplus("simulate manhattan --size 400 --seed 2 --outliers 0.1 -o map.g2o --truth truth.g2o");
    let run = folder.boxplus("solve map.g2o --robust cauchy:1 --json");
    let document = run.json();
    assert_eq!(document["robust"], "cauchy:1");
    assert!(document["cost"].as_f64() < document["costs"]["log"].as_f64(), "{document}");
}

#[test]
fn indefinite_information_is_mended_or_left_out_when_asked() {
    let map = SQUARE.replacen("100 0 0 100 0 400", "100 0 0 -100 0 400", 1);
    let folder = Folder::new().with("map.g2o", map);
    assert_eq!(folder.boxplus("solve map.g2o").code, 3);
    for policy in ["clamp", "skip"] {
        let run = folder.boxplus(&format!("solve map.g2o --json --information {policy}"));
        assert_eq!(run.code, 0, "{policy}: {}", run.stderr);
        assert_eq!(run.json()["mended"], serde_json::json!([5]), "{policy}");
    }
    // The name it had before.
    assert!(folder.boxplus("solve map.g2o --indefinite skip").stdout.contains("mended    1 measurement"));
    assert_eq!(folder.boxplus("plot map.g2o -o map.svg").code, 0);
}

#[test]
fn standard_input_and_output_carry_graphs() {
    let folder = Folder::new();
    let run = folder.boxplus_fed("solve - -o -", SQUARE);
    assert_eq!(run.code, 0);
    assert!(run.stdout.starts_with("VERTEX_SE2 0 "), "{}", run.stdout);
    assert!(run.stderr.contains("<stdin>") && run.stderr.contains("cost"), "{}", run.stderr);
    let run = folder.boxplus_fed("convert - - --to toro", SQUARE);
    assert!(run.stdout.starts_with("VERTEX2 0 "), "{}", run.stdout);
    assert_eq!(folder.names(), [""; 0]);
}

#[test]
fn gzip_comes_in_and_goes_out() {
    let folder = square();
    assert_eq!(folder.boxplus("convert map.g2o packed.g2o.gz").code, 0);
    assert!(folder.read("packed.g2o.gz").starts_with(b"\x1f\x8b"));
    assert_eq!(folder.boxplus("convert packed.g2o.gz back.g2o").code, 0);
    assert_eq!(folder.read("back.g2o"), SQUARE.as_bytes());
}

#[test]
fn diagnose_names_what_floats_and_what_fits() {
    let run = square().boxplus("diagnose map.g2o");
    assert_eq!(run.code, 0);
    settings().bind(|| insta::assert_snapshot!(run.transcript()));
}

#[test]
fn diagnose_names_false_loop_closures_and_solve_leaves_them_out() {
    let folder = Folder::new();
    let run = folder.boxplus("diagnose demo:manhattan --size 300 --outliers 0.1 --seed 1 --json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let named: usize = run.json()["fit"]["contradicting"]
        .as_array()
        .unwrap()
        .iter()
        .map(|g| g.as_array().unwrap().len())
        .sum();
    assert!(named > 3);
    let run =
        folder.boxplus("solve demo:manhattan --size 300 --outliers 0.1 --seed 1 --robust gnc-tls --json");
    assert_eq!(run.json()["rejected_closures"].as_array().unwrap().len(), named);
    let run = folder
        .boxplus("solve demo:manhattan --size 300 --outliers 0.1 --seed 1 --robust pcm+gnc-tls --json")
        .json();
    assert_eq!(run["rejected_closures"].as_array().unwrap().len(), named);
    let kept = run["pairwise"]["kept"].as_u64().unwrap();
    assert!(kept < run["loop_closures"].as_u64().unwrap());
    let run = folder.boxplus("solve demo:manhattan --size 300 --outliers 0.1 --seed 1 --robust pcm");
    assert!(run.stdout.contains("agree with each other"), "{}", run.stdout);
    for bad in ["gnc-tls:0", "gnc-gm:x", "gnc", "pcm:1", "gnc-tls+pcm"] {
        assert_eq!(folder.boxplus(&format!("solve demo:sphere --robust {bad}")).code, 2, "{bad}");
    }
}

#[test]
fn info_counts_and_checks() {
    let folder = Folder::new()
        .with("map.g2o", format!("{SQUARE}FIX 0\nEDGE_SE2 3 0 1 0 1.57 100 0 0 100 0 400\nROBOT 7\n"));
    let run = folder.boxplus("info map.g2o");
    assert_eq!(run.code, 0);
    settings().bind(|| insta::assert_snapshot!(run.transcript()));
    let document = folder.boxplus("info map.g2o --json").json();
    let expected =
        [("poses", 4), ("measurements", 5), ("loop_closures", 2), ("repeated_edges", 1), ("fixed", 1)];
    for (field, count) in expected {
        assert_eq!(document[field].as_u64(), Some(count), "{field}: {document}");
    }
    assert_eq!(document["other"], serde_json::json!([{"tag": "ROBOT", "count": 1}]));
}

#[test]
fn simulations_repeat_by_their_seed() {
    let folder = Folder::new();
    for world in ["sphere", "torus", "grid", "manhattan", "garage", "landmarks"] {
        for (seed, name) in [(1, "a.g2o"), (1, "b.g2o"), (2, "c.g2o")] {
            let run = folder
                .boxplus(&format!("simulate {world} --size 50 --seed {seed} -o {name} --truth truth-{name}"));
            assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{world}");
        }
        assert_eq!(folder.read("a.g2o"), folder.read("b.g2o"), "{world}");
        assert_ne!(folder.read("a.g2o"), folder.read("c.g2o"), "{world}");
        assert!(folder.read("truth-a.g2o").starts_with(b"VERTEX"), "{world}");
    }
}

#[test]
fn every_demo_is_solved_and_drawn() {
    let folder = Folder::new();
    for world in ["sphere", "torus", "grid", "manhattan", "garage", "landmarks"] {
        let run =
            folder.boxplus(&format!("solve demo:{world} --size 120 --json --plot {world}.svg --covariance"));
        assert_eq!(run.code, 0, "{world}: {}", run.stderr);
        assert!(folder.read(&format!("{world}.svg")).starts_with(b"<svg"), "{world}");
    }
    assert_eq!(folder.boxplus("plot demo:torus --size 60 -o torus.png").code, 0);
    assert!(folder.read("torus.png").starts_with(b"\x89PNG"));
}

#[test]
fn a_graph_without_vertices_is_drawn_at_its_first_estimate() {
    let edges: Vec<_> = SQUARE.lines().filter(|line| line.starts_with("EDGE")).collect();
    let folder = Folder::new().with("map.g2o", edges.join("\n"));
    assert_eq!(folder.boxplus("plot map.g2o -o map.svg").code, 0);
    assert!(String::from_utf8(folder.read("map.svg")).unwrap().contains("First estimate"));
}

#[test]
fn every_verb_has_a_document_for_machines() {
    let folder = square();
    for (verb, arguments) in [
        ("solve", "map.g2o"),
        ("info", "map.g2o"),
        ("diagnose", "map.g2o"),
        ("convert", "map.g2o out.graph"),
        ("simulate", "grid --size 30 -o grid.g2o --truth truth.g2o"),
        ("plot", "map.g2o -o map.svg"),
    ] {
        let run = folder.boxplus(&format!("{verb} {arguments} --json"));
        let document = run.json();
        assert_eq!(document["format"], format!("boxplus.{verb}"));
        assert_eq!(document["version"], 1);
    }
}

#[test]
fn wrong_usage_is_exit_code_2() {
    let folder = square();
    for arguments in [
        "solv map.g2o",
        "solve map.g2o --robust soft",
        "solve map.g2o --chart mercator",
        "solve map.g2o --gradient -1",
        "solve map.g2o --covariance",
        "solve map.g2o --threads 0",
        "solve map.g2o --size 10",
        "solve map.g2o -o out.txt",
        "solve map.g2o -o out.isam",
        "solve map.g2o -o - --json",
        "simulate grid -o - --truth -",
        "solve map.g2o --plot out.bmp",
        "solve map.g2o --fix 77",
        "solve demo:moon",
        "solve demo:sphere --size 0",
        "solve demo:manhattan --outliers 2",
        "simulate moon -o out.g2o",
        "plot map.g2o -o picture",
        "completions cmd",
    ] {
        let run = folder.boxplus(arguments);
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{arguments}: {}", run.stderr);
        assert!(!run.stderr.is_empty(), "{arguments}");
    }
    assert_eq!(folder.names(), ["map.g2o"]);
}

#[test]
fn an_answer_that_the_data_leave_open_is_exit_code_4() {
    let sightings = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_XY 2 3 1\n\
        EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_BEARING_SE2_XY 0 2 0.3 10\n";
    let folder = Folder::new().with("map.g2o", sightings);
    let run = folder.boxplus("solve map.g2o");
    assert_eq!(run.code, 4, "{}", run.transcript());
    settings().bind(|| insta::assert_snapshot!(run.stderr));
}

#[test]
fn a_search_that_is_cut_short_is_exit_code_5_and_kept() {
    let folder = Folder::new();
    let run = folder.boxplus("solve demo:sphere --size 200 --init file --max-iterations 1 --json -o out.g2o");
    assert_eq!(run.code, 5);
    let document = run.json();
    assert_eq!((&document["converged"], &document["termination"]), (&false.into(), &"max_iterations".into()));
    assert_eq!(folder.names(), ["out.g2o"]);
}

#[test]
fn an_output_that_cannot_be_written_is_exit_code_1() {
    let run = square().boxplus("convert map.g2o nowhere/out.g2o");
    assert_eq!(run.code, 1);
    settings().bind(|| insta::assert_snapshot!(run.stderr));
}

#[cfg(unix)]
#[test]
fn an_interrupted_search_is_exit_code_130_and_kept() {
    let folder = Folder::new();
    let arguments = "solve demo:sphere --size 19600 --init file --relative-cost 0 --gradient 0 --step 0 \
        --max-iterations 1000000 -o out.g2o";
    let mut child = Command::new(env!("CARGO_BIN_EXE_boxplus"))
        .args(arguments.split_whitespace())
        .current_dir(folder.path(""))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(400));
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    let code = child.wait().unwrap().code();
    assert!(kill.success());
    assert_eq!(code, Some(130), "{said}");
    assert!(said.contains("the best poses so far are saved"), "{said}");
    assert_eq!(folder.names(), ["out.g2o"]);
}

#[test]
fn a_reader_that_leaves_early_is_no_trouble() {
    let folder = Folder::new();
    for arguments in
        ["simulate sphere -o -", "solve demo:sphere --size 100 --json", "completions zsh", "--help"]
    {
        let mut child = Command::new(env!("CARGO_BIN_EXE_boxplus"))
            .args(arguments.split_whitespace())
            .current_dir(folder.path(""))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let mut said = String::new();
        child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        assert!(!said.contains("panicked") && !said.contains("Broken pipe"), "{arguments}: {said}");
        assert_eq!(child.wait().unwrap().code(), Some(0), "{arguments}: {said}");
    }
}

#[test]
fn quiet_says_nothing_and_a_pipe_gets_no_colours() {
    let folder = square();
    let run = folder.boxplus("solve map.g2o -q -o out.g2o");
    assert_eq!((run.code, run.stdout.as_str(), run.stderr.as_str()), (0, "", ""));
    for arguments in ["solve map.g2o", "info map.g2o", "info nowhere"] {
        let run = folder.boxplus(arguments);
        assert!(!run.stdout.contains('\u{1b}') && !run.stderr.contains('\u{1b}'), "{arguments}");
    }
}

#[test]
fn help_has_examples_that_run() {
    for verb in
        ["", "solve", "info", "diagnose", "convert", "simulate", "plot", "pose", "consistency", "completions"]
    {
        let run = Folder::new().boxplus(&format!("{verb} --help"));
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{verb}");
        assert!(run.stdout.contains("Examples:"), "{verb}");
        let name = if verb.is_empty() { "help" } else { verb };
        settings().bind(|| insta::assert_snapshot!(format!("help_{name}"), run.stdout));
    }
    let folder = square();
    for example in
        ["solve demo:sphere --size 900 --noise 2 --seed 7 --plot sphere.png", "convert map.g2o map.graph"]
    {
        assert_eq!(folder.boxplus(example).code, 0, "{example}");
    }
}

#[test]
fn completions_know_the_verbs_and_the_choices() {
    for (shell, knows_values) in
        [("bash", true), ("zsh", true), ("fish", true), ("elvish", false), ("powershell", false)]
    {
        let run = Folder::new().boxplus(&format!("completions {shell}"));
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{shell}");
        let words = ["simulate", "max-iterations"].into_iter().chain(knows_values.then_some("spanning-tree"));
        for word in words {
            assert!(run.stdout.contains(word), "{shell} does not know {word}");
        }
    }
}

#[test]
fn the_bash_completions_are_valid_bash() {
    let script = Folder::new().boxplus("completions bash").stdout;
    let Ok(mut bash) = Command::new("bash").arg("-n").stdin(Stdio::piped()).spawn() else {
        eprintln!("skipped: no bash here");
        return;
    };
    bash.stdin.take().unwrap().write_all(script.as_bytes()).unwrap();
    assert!(bash.wait().unwrap().success());
}
