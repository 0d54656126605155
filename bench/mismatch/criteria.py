"""Every number that decides something in the mismatch analysis: its meaning, its source."""

from bench.identification.samples import spikes

STANDSTILL_RAD_S = 0.3
"""motor speed below which the bench counts as standing; a fifth of one count of a 13-bit encoder at 2 kHz"""
SURELY_MOVING_RAD_S = 1.5
"""motor speed from which any bench counts as moving: one count of a 13-bit encoder at 2 kHz (bench-physics,
"Notation"). While it passes the speeds below, another bench may count as standing, and its friction have no direction
"""
SPEED_NOISE = 2e-3
"""noise of the speed, over the speed of standstill, below which a shorter smoothing window is taken"""
SPIKE = spikes.SIGMA
"""standard deviations of the difference to a running median from which a sample is wild"""
KEEPS_ITS_LOAD = 0.02
"""standard deviation of the load in a steady segment, over the largest load, below which it is one level"""
REFERENCE_CELSIUS = 25.0
"""temperature to which f_vT and the cooling are referred (bench-physics, "Nominal simulation")"""
KEPT_LOAD_S = 1.0
"""over which the load is averaged where it keeps its level: what a torque sensor's noise does within is no load"""
LINE_POWER = 25.0
"""power of a line over the noise about it: ripple of the load motor, waves that shake the load; by chance e^-25 a line,
of which some thousand are looked at
"""
FEWEST_RECORDINGS = 6
"""recordings that can be fitted below which noise and structure are not told apart"""
ERROR_RATE = 0.01
"""chance of a false finding in a folder without any, chosen once"""
ERROR_RATE_OF_A_CHANNEL = ERROR_RATE / 4.0
"""the same in one of four channels"""
ERROR_RATE_OF_A_LOOK = ERROR_RATE_OF_A_CHANNEL / 5.0
"""the same for one of the kinds of structure that are looked for in what a channel leaves: bursts, scatter, levels or
steps, ringing, tones (Bonferroni)
"""
SHAPE = 0.2
"""how far nature's form of an effect may be from the library's, over the effect's own size beyond what the simulation
absorbs: standard deviation of the correction that stands beside each name"""
BLOCK_S = 5.0
"""length of the blocks whose signs are drawn, some correlation times of a bench's noise"""
BLOCK_MEMORIES = 3.0
"""correlation times of a residual in a block, where nothing but the residual tells how long noise remembers itself"""
WAVERING = 0.08
"""standard deviation of load (speed) inside a revolution, over the largest load (its mean), that still is one state"""
FEWEST_TURNS = 5
"""steady revolutions below which an order with one phase and one with a new phase each time are not told apart"""
RICHER = 3.0
"""log-likelihood that a dependence on direction, load, speed and temperature must gain over a plainer model of an
order: odds of twenty to one
"""
AS_GOOD = 0.2
"""probability of an alternative, over that of the effect told, from which the two are not told apart: odds of five to
one
"""
VERY_STRONG = 5.0
"""log density of points left out by which one name has to be better than another before only one is told: "very strong"
evidence in the table of Kass and Raftery (J. Am. Stat. Assoc. 90 (1995) 773). Less may be the form's and not the name's
"""
BESIDE_UNKNOWN_ERRORS = 2.0
"""standard errors of a difference by which a name has to predict points left out better than a free function where
something without a name stands in the channel already, or than another name if it does so by less than twice
:data:`VERY_STRONG`: one in forty by chance, as which a test of ranks counts as well
"""
ALIKE = 0.01
"""what two names predict apart, over the size of the effect, below which twice as strong evidence is asked for before
only one of them is told: a twentieth of :data:`SHAPE`, so that nature's form may differ from either by far more
"""
ONE_ERROR = 1.0
"""standard errors of a difference by which one of two may predict worse and still be as good: a formula than a table on
points left out, a name with fewer numbers than one that it may as well be, a model with an effect than without it on
recordings held out (the one-standard-error rule: Breiman, Friedman, Olshen, Stone, Classification and Regression Trees,
1984, section 3.4.3)
"""
LEAST_POWER = 1e-3
"""mean square of an order's wave over that of the noise of a sample, below which it is passed over: it adds half a
thousandth to what is left
"""
LOUDEST = 10.0
"""mean square of a block's residual, over the median block's, that counts in a surrogate: more is a place where the
model is off, no noise
"""
STRONG_ACCELERATION = 0.5
"""1/s: change of speed a second, over the fastest steady speed, from which the angles are not compared: they have
dynamics then that the simulation has not
"""
LEAST_STRENGTH = 0.15
"""size of an effect where it acts, over the noise of a sample, below which it is not told: a report of such would be
long and of no use, and no calibration is that good
"""
TRANSDUCER = 2e-4
"""of the largest torque, below which an effect in a torque is not told, nor one in the temperature that so small a
torque would heat: 0.02 % is the best class that torque transducers are sold in, so less is the sensor's own affair
"""
SELF_HEATING_K = 0.025
"""K, below which no shift of a thermometer's reading is told: its own current may warm a PT100 by a quarter of its
tolerance (IEC 60751, 0.1 K in class AA), and what flows past it cools it
"""
LEAST_OVERALL = 0.05
"""the same over all samples: less changes what is left by an eighth of a percent, and is told to be noise"""
ACTIVE_ENERGY = 0.95
"""share of an effect's energy that tells where it acts"""
LEAST_ACTIVE = 0.02
"""share of all samples in which an effect acts at least"""
FLOOR_ERRORS = 2.0
"""standard errors of the noise floor by which what is left may lie above it and still be noise: one in forty by
chance
"""
MORE_THAN_NOISE = 1.25
"""what is left, over the noise floor, from which it is told as structure whatever else says: half as much energy again,
more than slow noise that a floor misses and the calibration's own doubt come to
"""
EXERCISED = 0.02
"""share of the energy of a hysteresis' regressor that is no function of the torque, from which its loops were driven"""
LAW_BEYOND = 1e-3
"""share of a law's variation that no polynomial of the series can say, below which it is not asked for: its strength
would be known to no better than thirty times what the noise allows
"""
HIGHEST_MODULATION = 12
"""order per output revolution of a modulation: what turns slowly in a gearbox"""
NARROW = 4.0
"""times a modulation's order that its carrier's is at least: a sideband lies close to its carrier"""
SIDES_ALIKE = 0.35
"""standard deviation of the logarithm of the sizes' ratio of two sidebands: one side is half as large now and then
(amplitude and phase modulation together, McFadden 1987)
"""
PAIR_ALONE = 0.05
"""chance of a pair about a known order that is accepted where no other order stands: two plain orders and nothing else
are rarer than one modulation. Where others stand it is ``ERROR_RATE``
"""
SPOILED = -2.0
"""log-likelihood below which an order does not belong to a resonance's mode: odds of seven to one against it"""
USUAL_DAMPING, DAMPING_SPREAD = 0.06, 0.7
"""damping ratio of structures that resonate: median, and standard deviation of the logarithm; decides only where no
speed meets the mode
"""
SURE = 3.0
"""standard deviations of its own from which a law's strength is no accident of the calibration"""
NAMELESS = 2.0
"""how much stronger an order of the motor's shaft that no name fits has to be than a named one: encoders and control
loops
make small ones in every drive
"""
LEAST_P = 1e-4
"""smallest p-value that is told: a law through some hundred surrogates is trusted for little more than a decade
beyond them
"""
RIGHT_WHEN_SURE = 0.9
"""what all confidences are scaled by: (35 + 1)/(38 + 2) by Laplace's rule, for 35 of 38 findings of weight over 0.9
were right in folders of ``bench prove`` that the method had been mended on (seeds 162989 held back, 9101, 9201 with
clutter, 77001 and 77002 through the bench); docs/proof.md has how often they are right in folders never seen
"""
EITHER = 0.5
"""share of a confidence that is left where nothing says whether it is this or another: at the end of its range a
term turns into something else; of a size that may be nothing, something beside it may be the whole; recordings held out
that are predicted better without it do not bear it out
"""
TOLD = 1.96
"""standard deviations from nothing of at least one coefficient of a term whose size is told"""
OVER_THE_REST = 2.0
"""size of a name over that of what is left without an explanation, from which it is told where something without a name
stands beside it, or where more is left than noise: a form that leaves more than half of itself is no form of it
"""
CANNOT_BE_SPARED = 0.5
"""share of one operating point in what is known of an effect, above which the others cannot predict it there; and of
one recording in the energy of a law of the orders, above which it is no law
"""
