//! The folders tell the truth: a module imports only from those before it, and outside crates stay where they belong.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};

/// The modules in reading order.
const ORDER: [&str; 11] = [
    "lie",
    "uncertainty",
    "registration",
    "camera",
    "trajectory",
    "filter",
    "graph",
    "pose_graph",
    "bundle_adjustment",
    "recording",
    "io",
];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = vec![];
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Source without comments, so that docs may point anywhere.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_module_imports_only_from_those_before_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for (level, module) in ORDER.iter().enumerate() {
        for path in sources(&root.join(module)) {
            for later in &ORDER[level + 1..] {
                let import = format!("crate::{later}");
                assert!(!code(&path).contains(&import), "{} imports {import}", path.display());
            }
        }
    }
}

#[test]
fn one_file_names_the_oracle_of_the_factorisation_and_two_the_vectors_of_the_machine() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let naming = |name: &str| -> Vec<_> {
        sources(&root).into_iter().filter(|path| code(path).contains(name)).collect()
    };
    assert_eq!(naming("faer::"), [root.join("graph/linear/oracle.rs")]);
    // The dense kernels of the solver, and the batches of groups.
    assert_eq!(naming("pulp::"), [root.join("graph/linear/kernels.rs"), root.join("lie/batch.rs")]);
}

#[test]
fn no_file_is_longer_than_a_person_reads_in_a_sitting() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for path in sources(&root) {
        let text = code(&path);
        let own = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        let lines = own.lines().filter(|line| !line.trim().is_empty()).count();
        assert!(lines <= 400, "{} has {lines} lines of code", path.display());
    }
}

#[test]
fn filter_and_graph_never_meet() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for module in ["graph", "pose_graph"] {
        for path in sources(&root.join(module)) {
            assert!(!code(&path).contains("crate::filter"), "{} imports crate::filter", path.display());
        }
    }
}

/// Words in backticks of `docs/properties.md` that name a file or a folder.
#[test]
fn the_tests_that_hold_a_property_are_where_the_document_says() {
    let (root, crate_root) =
        (Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."), env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(root.join("docs/properties.md")).unwrap();
    let paths: Vec<_> = text.split('`').filter(|word| word.contains('/') && !word.contains(' ')).collect();
    assert!(paths.len() > 20);
    for path in paths {
        let found = root.join(path).exists() || Path::new(crate_root).join(path).exists();
        assert!(found, "{path} does not exist");
    }
}
