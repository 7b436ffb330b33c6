//! State-Indexed Task Updates: task models as automata of primitives, and how corrective demonstrations change them.
