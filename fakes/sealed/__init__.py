"""What the examiner knows of a plant with physics concealed in it: the truth to be sealed before anybody analyses.

It stands above the plant and the generator's own measures of strength and place, and knows nothing of the bench:
recordings come as arrays.
"""

from fakes.plant.hidden.ledger import EVERY
from fakes.sealed.description import concealed_in, nominal_truth
from fakes.sealed.truth import noise_of, truth_of

__all__ = ["EVERY", "concealed_in", "noise_of", "nominal_truth", "truth_of"]
