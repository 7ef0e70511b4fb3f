"""AWS DeepRacer's files: reward_function.py, model_metadata.json, hyperparameters.json."""
