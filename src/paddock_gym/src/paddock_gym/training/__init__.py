"""Training by PPO of stable-baselines3: what ./run train does. Needs torch."""
