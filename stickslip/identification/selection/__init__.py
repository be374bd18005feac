"""Which friction law explains a recording: each predicts the parts that it was not fitted to."""
