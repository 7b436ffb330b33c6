//! The output of gungraun's runner for a bench: the number of its instructions.

use serde::Deserialize;

use crate::error::BenchError;

/// The part that is read of the runner's output for a bench.
#[derive(Deserialize)]
struct Summary {
    group: String,
    function_name: String,
    id: Option<String>,
    profiles: serde_json::Value,
}

/// The name of a bench and the instructions that it took, from the line of JSON that gungraun's runner writes of it.
///
/// # Errors
/// [`BenchError::Valgrind`] where the line is none, or has no such number.
pub fn counted(line: &str) -> Result<(String, u64), BenchError> {
    let refuse = |problem: String| BenchError::Valgrind { problem: format!("gungraun's summary: {problem}") };
    let Summary { group, function_name, id, profiles } =
        serde_json::from_str(line).map_err(|error| refuse(error.to_string()))?;
    let name = [Some(group), Some(function_name), id].into_iter().flatten().collect::<Vec<_>>().join("::");
    // The number of this run; beside it may be that of the last run, under `old`.
    let count = profiles.pointer("/0/data/total/metrics/Ir/values/new").and_then(serde_json::Value::as_u64);
    let count = count.ok_or_else(|| refuse(format!("no number of instructions of `{name}`")))?;
    Ok((name, count))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIT: &str = "kernels::hmm_fit::twenty_iterations";

    /// Lines of version 0.20 of the runner, cut down to the part that is read.
    #[test]
    fn the_runner_s_line_is_read() {
        let line = |values: &str, id: &str| {
            let profiles =
                format!(r#"[{{"tool":"callgrind","data":{{"total":{{"metrics":{{"Ir":{{{values}}}}}}}}}}}]"#);
            format!(r#"{{"function_name":"hmm_fit","group":"kernels",{id}"profiles":{profiles},"version":"1"}}"#)
        };
        let id = r#""id":"twenty_iterations","#;
        assert_eq!(counted(&line(r#""values":{"new":7}"#, id)).unwrap(), (FIT.to_owned(), 7));
        let compared = line(r#""change":{"factor":1.0},"values":{"new":7,"old":9}"#, "");
        assert_eq!(counted(&compared).unwrap(), ("kernels::hmm_fit".to_owned(), 7));
        for bad in [line(r#""values":{"old":9}"#, id), "kernels::hmm_fit".to_owned()] {
            let error = counted(&bad).unwrap_err().to_string();
            assert!(error.starts_with("valgrind: gungraun's summary: "), "{error}");
        }
    }
}
