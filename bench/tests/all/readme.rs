//! The README's table is the published one, and its map and links are true.

use std::fs;
use std::path::Path;

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

#[test]
fn the_table_is_the_published_one() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let file = "results/quick/headline.md";
    let begin = format!("<!-- begin {file} -->\n");
    let end = format!("<!-- end {file} -->");
    let start = readme.find(&begin).expect("the README's table begins with its marker") + begin.len();
    let length = readme[start..].find(&end).expect("and ends with one");
    let published = fs::read_to_string(root().join(file)).unwrap();
    let rows: String = published.lines().filter(|line| line.starts_with('|')).map(|line| format!("{line}\n")).collect();
    assert!(rows.lines().count() > 2, "{file} holds a table");
    assert_eq!(
        readme[start..start + length].trim(),
        rows.trim(),
        "put the rows of {file} between the README's markers"
    );
}

#[test]
fn every_link_to_a_file_leads_somewhere() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let targets: Vec<&str> = readme.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    assert!(targets.len() > 10);
    for target in targets {
        assert!(root().join(target).exists(), "README.md links to {target}, which is not there");
    }
}
