#!/usr/bin/python3
"""The networks of an export in NumPy alone: prints what `dadrl act --json` prints, for comparison.

Usage: forward.py EXPORT_DIR OBSERVATIONS_DIR      (Debian's python3-numpy; the layouts: docs/open_models.md)
"""
import json
import sys
from pathlib import Path

import numpy as np


def dense(p, name, x):
    return x @ p[name + '.weight'].T + p[name + '.bias']


def relu(x):
    return np.maximum(x, 0)


def sigmoid(x):
    return 1 / (1 + np.exp(-x))


def layer_norm(x, epsilon):
    return (x - x.mean(-1, keepdims=True)) / np.sqrt(x.var(-1, keepdims=True) + epsilon)


def lstm(p, name, sequences):
    """[N, steps, 7] to the last hidden state [N, 56]."""
    h = c = np.zeros((len(sequences), p[name + '.weight_hh'].shape[1]))
    for x in np.moveaxis(sequences, 1, 0):
        sums = x @ p[name + '.weight_ih'].T + h @ p[name + '.weight_hh'].T + p[name + '.bias']
        i, f, g, o = np.split(sums, 4, -1)
        c = sigmoid(f) * c + sigmoid(i) * np.tanh(g)
        h = sigmoid(o) * np.tanh(c)
    return h


def attend(p, name, ego, vehicles, absent):
    """ego [N, 56], vehicles [N, V, 56], absent [N, V]: the residual sum [N, 56] and the weights [N, V]."""
    query = dense(p, name + '.query', ego)[:, None]
    score = (dense(p, name + '.key', vehicles) * query).sum(-1) / np.sqrt(ego.shape[-1])
    score = np.where(absent, -np.inf, score)
    highest = np.maximum(score.max(-1, keepdims=True), 0)  # the zero slot's score is 0
    weight = np.exp(score - highest)
    weight /= weight.sum(-1, keepdims=True) + np.exp(-highest)
    value = (weight[..., None] * dense(p, name + '.value', vehicles)).sum(1)
    return ego + dense(p, name + '.output', value), weight


def convolution(p, name, x):
    weight, bias = p[name + '.weight'], p[name + '.bias']
    windows = np.lib.stride_tricks.sliding_window_view(x, weight.shape[2:], (2, 3))[:, :, ::2, ::2]
    return relu(np.einsum('ncyxij,ocij->noyx', windows, weight, optimize=True) + bias[:, None, None])


def encode(p, model, vehicles, ego, context):
    count, present, steps, features = vehicles.shape
    parts, weight = [ego.reshape(count, -1), vehicles.reshape(count, -1)], None
    if model['stae']:
        sequences = np.concatenate([ego[:, None, :, :features], vehicles], 1).reshape(-1, steps, features)
        hidden = lstm(p, 'encoder.stae.lstm', sequences).reshape(count, 1 + present, -1)
        absent = vehicles[:, :, -1, 0] > 0.5
        summed, weight = attend(p, 'encoder.stae.attention', hidden[:, 0], hidden[:, 1:], absent)
        joined = np.concatenate([ego[:, -1], layer_norm(summed, model['layer_norm_epsilon'])], 1)
        parts = [relu(dense(p, 'encoder.stae.output', joined))]
    if model['context']:
        for layer in range(1, 6):
            context = convolution(p, f'encoder.context.conv{layer}', context)
        parts.append(relu(dense(p, 'encoder.context.output', context.reshape(count, -1))))
    return np.concatenate(parts, 1), weight


def mlp(p, name, x, epsilon=None):
    for layer in ('.hidden1', '.hidden2'):
        x = dense(p, name + layer, x)
        x = relu(x if epsilon is None else layer_norm(x, epsilon))
    return dense(p, name + '.output', x)


def main(export, observations):
    index = json.loads((export / 'index.json').read_text())
    model = index['model']
    networks = {name: {t['name']: np.load(export / t['file']).astype(float) for t in tensors}
                for name, tensors in index['networks'].items()}
    arrays = [np.load(observations / f'{name}.npy').astype(float) for name in ('vehicles', 'ego', 'context')]
    features, weight = encode(networks['policy'], model, *arrays)
    mean, log_std = np.split(mlp(networks['policy'], 'policy', features), 2, -1)
    action = np.tanh(mean)
    result = {'observations': len(mean), 'mean': mean, 'action': action, 'attention': weight,
              'log_std': log_std.clip(model['log_std_min'], model['log_std_max'])}
    if 'critic' in networks:
        features, _ = encode(networks['critic'], model, *arrays)
        epsilon = model['layer_norm_epsilon'] if model['critic_layer_norm'] else None
        for q in ('1', '2'):
            result['q' + q] = mlp(networks['critic'], 'critic' + q, np.hstack([features, action]), epsilon)[:, 0]
    print(json.dumps(result, default=np.ndarray.tolist))


if __name__ == '__main__':
    main(Path(sys.argv[1]), Path(sys.argv[2]))
