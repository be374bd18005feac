"""Operators of the genetic algorithm."""
