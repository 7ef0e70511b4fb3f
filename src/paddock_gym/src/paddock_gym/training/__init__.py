"""Training by PPO of stable-baselines3: the work of ./run train. Needs torch."""
