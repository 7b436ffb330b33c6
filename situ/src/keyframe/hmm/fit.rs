//! Expectation maximisation of a left-to-right model (decisions D12 to D14).

use nalgebra::{Matrix6, Translation3, Vector3};

use super::emission::{Covariance, Emission, Observation};
use super::frames::Frames;
use super::gripper::GripperEmission;
use super::inference::Recursion;
use super::model::Hmm;
use super::parameters::{HmmError, HmmParameters};
use super::residuals::{Residuals, mean_step};
use super::transition::{farthest, last_start, proportions};
use crate::demonstration::{Gripper, Pose};
use crate::keyframe::pose::{MEAN_STEPS, MEAN_TOLERANCE, dominant_rotation, turn};
use crate::vector::{LANES, fours_mut, sum};

/// A state with at most this many expected frames keeps its parameters.
const EMPTY_STATE: f64 = 1e-12;
/// Two log determinants that differ by less than this are the same up to rounding. If a state has next to no frames,
/// both are the prior's.
const ROUNDING: f64 = 1e-9;
/// Re-estimations that the records of a fit have room for at the start.
const USUAL_ITERATIONS: usize = 100;
/// A frame whose share of a state is below this part of the total is left out of the state's sums. All such frames
/// together are below the rounding error.
const NEGLIGIBLE_SHARE: f64 = 1e-20;

/// A fitted model, and how the fit went.
#[derive(Clone, Debug, PartialEq)]
pub struct HmmFit {
    /// The model.
    pub hmm: Hmm,
    /// The number of re-estimations.
    pub iterations: usize,
    /// Whether the objective came to rest before the iterations ran out.
    pub converged: bool,
    /// The log likelihood of the sequences before the first re-estimation and after each: `iterations + 1` numbers.
    pub log_likelihoods: Vec<f64>,
    /// The objective that the re-estimation climbs, at the same moments: the log likelihood plus the log prior of the
    /// covariances and of the gripper commands, up to constants.
    ///
    /// No re-estimation lowers it, up to rounding; the log likelihood alone can fall. With rotations a guard is needed
    /// for that. The weighted mean on the manifold need not be the best mean for a full covariance. If it is worse than
    /// the mean before, each with its own best covariance, the mean before stays for this step.
    pub objectives: Vec<f64>,
    /// The expected number of frames in each state under the model, shape (K).
    pub occupancy: Vec<f64>,
}

impl HmmFit {
    /// The log likelihood of the sequences under the model.
    pub fn log_likelihood(&self) -> f64 {
        *self.log_likelihoods.last().expect("that of the start at least")
    }
}

/// What one fit needs besides the model. It is allocated once, before the first re-estimation.
struct Workspace {
    recursion: Recursion,
    poses: Vec<Pose>,
    frames: Frames,
    grippers: Vec<Option<Gripper>>,
    /// One per state, shape (K): the residual of every frame in the tangent space at the state's mean. The distances of
    /// the E step, the first step of the next mean and the scatter about the present mean are all computed from these.
    residuals: Vec<Residuals>,
    /// The residuals of one state at a mean that is tried.
    tried: Residuals,
    /// The covariances of one state: about its next mean, and about its mean before.
    covariances: [Covariance; 2],
    /// The share of one state in every frame, 0 if it is negligible; padded.
    weights: Vec<f64>,
    /// The indices of those fours of frames in which some share is above 0.
    nonzero: Vec<usize>,
}

impl Hmm {
    /// Fits a left-to-right model of `states` states. Each state can stay, go to the next, end, and skip the next if
    /// `skip` is set.
    ///
    /// The start is each sequence cut into `states` even runs. Then expectation maximisation re-estimates the model,
    /// maximum a posteriori: Σ = (Σγrrᵀ + ν₀S₀)/(Σγ + ν₀), where r is the residual in the tangent space at the weighted
    /// mean pose. The probabilities of the chain are proportional to their expected counts, but never below the floor.
    /// The same input gives the same bits.
    ///
    /// # Errors
    /// If there is no sequence, a sequence has no frame, a number is not finite, `states` is 0, or a parameter is out
    /// of its range. With a floor of 0, also if a sequence is impossible.
    pub fn fit(sequences: &[&[Observation]], states: usize, parameters: &HmmParameters) -> Result<HmmFit, HmmError> {
        if states == 0 {
            return Err(HmmError::NoState);
        }
        let mut workspace = Workspace::new(sequences, states, parameters)?;
        let mut hmm = blank(states, &workspace, parameters)?;
        workspace.cut_evenly(states);
        workspace.begin(&mut hmm, parameters)?;
        workspace.climb(hmm, parameters)
    }

    /// [`Hmm::fit`] from this model instead of the even cut: a re-estimation after new data came.
    ///
    /// # Errors
    /// As [`Hmm::fit`]. Also [`HmmError::Topology`] if this model has transitions that the parameters do not allow.
    pub fn refit(&self, sequences: &[&[Observation]], parameters: &HmmParameters) -> Result<HmmFit, HmmError> {
        let k = self.states();
        if k == 0 {
            return Err(HmmError::NoState);
        }
        let shaped = self.initial.len() == k && self.end.len() == k && self.transition.len() == k * k;
        let open = |at: usize| (at / k..=farthest(at / k, k, parameters.skip)).contains(&(at % k));
        let starts = |state: usize| state <= last_start(k, parameters.skip);
        if !shaped
            || self.transition.iter().enumerate().any(|(at, probability)| *probability > 0.0 && !open(at))
            || self.initial.iter().enumerate().any(|(state, probability)| *probability > 0.0 && !starts(state))
        {
            return Err(HmmError::Topology);
        }
        let mut workspace = Workspace::new(sequences, k, parameters)?;
        for (residuals, emission) in workspace.residuals.iter_mut().zip(&self.emissions) {
            residuals.measure(&workspace.frames, &emission.mean, &workspace.weights);
        }
        workspace.climb(self.clone(), parameters)
    }
}

/// The model before any data: every open way equally likely, every state at the prior.
fn blank(states: usize, workspace: &Workspace, parameters: &HmmParameters) -> Result<Hmm, HmmError> {
    let gripper = workspace.grippers.iter().any(Option::is_some).then(GripperEmission::unseen);
    let emission = Emission::new(Pose::identity(), prior(parameters), Matrix6::zeros(), gripper)?;
    let mut hmm = Hmm {
        initial: vec![0.0; states],
        transition: vec![0.0; states * states],
        end: vec![0.0; states],
        emissions: vec![emission; states],
    };
    let last = last_start(states, parameters.skip);
    hmm.initial[..=last].fill(1.0 / (last + 1) as f64);
    for state in 0..states {
        let farthest = farthest(state, states, parameters.skip);
        let share = 1.0 / (farthest - state + 2) as f64;
        hmm.transition[state * states + state..=state * states + farthest].fill(share);
        hmm.end[state] = share;
    }
    Ok(hmm)
}

/// S₀.
fn prior(parameters: &HmmParameters) -> Matrix6<f64> {
    Matrix6::from_fn(|row, column| {
        let floor = parameters.floor(row);
        if row == column { floor * floor } else { 0.0 }
    })
}

impl Workspace {
    fn new(sequences: &[&[Observation]], states: usize, parameters: &HmmParameters) -> Result<Self, HmmError> {
        parameters.check()?;
        if sequences.is_empty() {
            return Err(HmmError::NoSequence);
        }
        let (mut poses, mut grippers, mut starts) = (Vec::new(), Vec::new(), vec![0]);
        for (index, sequence) in sequences.iter().enumerate() {
            if sequence.is_empty() {
                return Err(HmmError::EmptySequence { sequence: index });
            }
            for (frame, observation) in sequence.iter().enumerate() {
                let pose = &observation.pose;
                let finite = pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite());
                if !finite || observation.gripper.is_some_and(|command| !command.value().is_finite()) {
                    return Err(HmmError::NotFinite { sequence: index, frame });
                }
                poses.push(*pose);
                grippers.push(observation.gripper);
            }
            starts.push(poses.len());
        }
        let frames = Frames::new(poses.iter());
        Ok(Self {
            recursion: Recursion::new(starts, states),
            residuals: (0..states).map(|_| Residuals::new(&frames)).collect(),
            tried: Residuals::new(&frames),
            covariances: [Covariance::new(prior(parameters))?, Covariance::new(prior(parameters))?],
            weights: vec![0.0; frames.padded()],
            nonzero: Vec::with_capacity(frames.padded() / LANES),
            poses,
            frames,
            grippers,
        })
    }

    /// The start: frame t of T belongs to state ⌊tK/T⌋. If a sequence has fewer frames than there are states, a state
    /// without a frame borrows the frame that is nearest to its place.
    fn cut_evenly(&mut self, states: usize) {
        for sequence in 0..self.recursion.starts().len() - 1 {
            let [start, after] = [0, 1].map(|end| self.recursion.starts()[sequence + end]);
            let frames = after - start;
            let mut before = None;
            for frame in 0..frames {
                let state = frame * states / frames;
                *self.recursion.occupancy_mut(start + frame, state) = 1.0;
                if let Some(before) = before {
                    self.recursion.transitions_mut()[before * states + state] += 1.0;
                }
                before = Some(state);
            }
            for state in 0..states {
                let nearest = (2 * state + 1) * frames / (2 * states);
                if frames < states {
                    *self.recursion.occupancy_mut(start + nearest, state) = 1.0;
                }
            }
        }
    }

    /// Re-estimates until the objective comes to rest.
    fn climb(&mut self, mut hmm: Hmm, parameters: &HmmParameters) -> Result<HmmFit, HmmError> {
        let moments = parameters.max_iterations.min(USUAL_ITERATIONS) + 1;
        let mut log_likelihoods = Vec::with_capacity(moments);
        let mut objectives: Vec<f64> = Vec::with_capacity(moments);
        let mut iterations = 0;
        loop {
            let log_likelihood = self.expect(&hmm)?;
            let objective: f64 =
                log_likelihood + hmm.emissions.iter().map(|emission| emission.log_prior(parameters)).sum::<f64>();
            let rests =
                objectives.last().is_some_and(|last| (objective - last).abs() < parameters.tolerance * last.abs());
            log_likelihoods.push(log_likelihood);
            objectives.push(objective);
            if rests || iterations == parameters.max_iterations {
                let of = |state| (0..self.frames.len()).map(|frame| self.recursion.occupancy(frame, state)).sum();
                let occupancy = (0..hmm.states()).map(of).collect();
                return Ok(HmmFit { hmm, iterations, converged: rests, log_likelihoods, objectives, occupancy });
            }
            self.maximise::<true>(&mut hmm, parameters)?;
            iterations += 1;
        }
    }

    /// The E step. Returns the log likelihood of all sequences.
    fn expect(&mut self, hmm: &Hmm) -> Result<f64, HmmError> {
        for (state, (emission, residuals)) in hmm.emissions.iter().zip(&self.residuals).enumerate() {
            let column = self.recursion.log_densities_mut().column_mut(state);
            residuals.log_densities(emission.gaussian(), column);
            emission.add_log_densities_of_commands(self.grippers.iter().copied(), column);
        }
        let log_likelihoods = self.recursion.expect(hmm);
        match log_likelihoods.iter().position(|log_likelihood| *log_likelihood == f64::NEG_INFINITY) {
            Some(sequence) => Err(HmmError::Impossible { sequence }),
            None => Ok(log_likelihoods.iter().sum()),
        }
    }

    /// The first M step. Its shares come from the even cut, so the means before it are no guess.
    fn begin(&mut self, hmm: &mut Hmm, parameters: &HmmParameters) -> Result<(), HmmError> {
        for (state, emission) in hmm.emissions.iter_mut().enumerate() {
            if self.gather(state).is_some() {
                let rotation = dominant_rotation(&self.poses, &self.weights);
                emission.mean = Pose::from_parts(Translation3::identity(), rotation);
                self.residuals[state].measure(&self.frames, &emission.mean, &self.weights);
            }
        }
        self.maximise::<false>(hmm, parameters)
    }

    /// The M step. If the means are a `GUESS`, a mean that is better than the next one stays.
    fn maximise<const GUESS: bool>(&mut self, hmm: &mut Hmm, parameters: &HmmParameters) -> Result<(), HmmError> {
        self.maximise_chain(hmm, parameters);
        let prior = prior(parameters) * parameters.prior_weight;
        for (state, emission) in hmm.emissions.iter_mut().enumerate() {
            let Some(total) = self.gather(state) else { continue };
            let gripper = self.gripper(emission.gripper, parameters);
            let residuals = &mut self.residuals[state];
            let (sum, about_guess) = residuals.moments(&self.weights, &self.nonzero);
            let position = emission.mean.translation.vector + sum.fixed_rows::<3>(0) / total;
            let turns = about_guess.fixed_view::<3, 3>(3, 3) / total;
            let step = |sum: Vector3<f64>| mean_step(&(sum / total), &turns);
            let comes_to_rest = |step: &Vector3<f64>| step.dot(step) < MEAN_TOLERANCE * MEAN_TOLERANCE;
            let mut mean = Pose::from_parts(Translation3::from(position), emission.mean.rotation);
            let mut next = step(sum.fixed_rows::<3>(3).into());
            let mut turned = false;
            for _ in 0..MEAN_STEPS {
                if comes_to_rest(&next) {
                    break;
                }
                mean.rotation = turn(&mean.rotation, &next);
                next = step(self.tried.measure(&self.frames, &mean, &self.weights));
                turned = true;
            }
            if !turned {
                residuals.measure_positions(&self.frames, &position);
            }
            let at_next = if turned { &self.tried } else { &*residuals };
            let about_next = at_next.moments(&self.weights, &self.nonzero).1;
            // The best covariance for a mean, from the weighted scatter about that mean.
            let [next, stayed] = &mut self.covariances;
            next.set(&about_next, &prior, total + parameters.prior_weight)?;
            if turned && GUESS {
                // If each mean has its best covariance, the objective is lower where the determinant is greater.
                stayed.set(&about_guess, &prior, total + parameters.prior_weight)?;
                if stayed.log_determinant < next.log_determinant - ROUNDING {
                    emission.set(emission.mean, stayed, (&about_guess, total), gripper);
                    continue;
                }
            }
            if turned {
                core::mem::swap(residuals, &mut self.tried);
            }
            emission.set(mean, next, (&about_next, total), gripper);
        }
        Ok(())
    }

    /// Reads the share of a state in every frame, and returns the sum of the shares. `None` if the sum is next to 0.
    fn gather(&mut self, state: usize) -> Option<f64> {
        self.recursion.occupancy_of(state, &mut self.weights);
        let total = sum(&self.weights);
        if total <= EMPTY_STATE {
            return None;
        }
        let negligible = NEGLIGIBLE_SHARE * total;
        self.nonzero.clear();
        for (block, weights) in fours_mut(&mut self.weights).iter_mut().enumerate() {
            for weight in weights.iter_mut() {
                *weight = if *weight > negligible { *weight } else { 0.0 };
            }
            if *weights != [0.0; LANES] {
                self.nonzero.push(block);
            }
        }
        Some(total)
    }

    /// The gripper command, from the frames that count.
    fn gripper(&self, before: Option<GripperEmission>, parameters: &HmmParameters) -> Option<GripperEmission> {
        let mut gripper = before?;
        let commands = self.grippers.iter().zip(&self.weights);
        let commands = commands.filter_map(|(command, weight)| (*weight > 0.0).then_some(((*command)?, *weight)));
        gripper.estimate(commands, EMPTY_STATE, parameters);
        Some(gripper)
    }

    /// The starts, transitions and ends, from the expected counts.
    fn maximise_chain(&self, hmm: &mut Hmm, parameters: &HmmParameters) {
        let k = hmm.states();
        let floor = parameters.transition_floor;
        let starts = self.recursion.starts();
        let mut ways = [0.0; 4];
        let last = last_start(k, parameters.skip);
        for (state, way) in ways[..=last].iter_mut().enumerate() {
            *way = starts[..starts.len() - 1].iter().map(|start| self.recursion.occupancy(*start, state)).sum();
        }
        if proportions(&mut ways[..=last], floor) {
            hmm.initial[..=last].copy_from_slice(&ways[..=last]);
        }
        for state in 0..k {
            let row = state * k + state..=state * k + farthest(state, k, parameters.skip);
            let open = row.clone().count();
            ways[..open].copy_from_slice(&self.recursion.transitions()[row.clone()]);
            ways[open] = starts[1..].iter().map(|after| self.recursion.occupancy(after - 1, state)).sum();
            if proportions(&mut ways[..=open], floor) {
                hmm.transition[row].copy_from_slice(&ways[..open]);
                hmm.end[state] = ways[open];
            }
        }
    }
}
