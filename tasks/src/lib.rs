//! Table-top tasks as files: scenes, predicates, skills, variations.
