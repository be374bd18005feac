"""Which friction law explains a recording: each predicts the parts that it was not fitted to."""

from stickslip.identification.selection.choice import Choice, choose
from stickslip.identification.selection.prediction import (
    Candidate,
    Prediction,
    candidates,
    predict,
    predictions,
)

__all__ = ["Candidate", "Choice", "Prediction", "candidates", "choose", "predict", "predictions"]
