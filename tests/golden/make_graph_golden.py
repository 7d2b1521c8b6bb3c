#!/usr/bin/env python3
"""Writes graph/*.npy: what PyTorch computes in float64 for each kind of node of common/nn/graph, forward and backward.

Usage: /usr/bin/python3 tests/golden/make_graph_golden.py      (Debian's python3-torch; the tests need neither)

Each case is the small network of the same name in tests/common/nn/graph/graph_cases.h: parameters and inputs come from
the hash of make_golden.py, the loss is the output times fixed numbers.
"""
import math
import numpy as np
import torch
import torch.nn.functional as F
from make_golden import flat, save, tensor, uniform

BATCH = 5


class Parameters:
    """Hands out tensors in the order in which the graph adds them to its layout."""

    def __init__(self):
        self.all = []

    def take(self, *shape):
        self.all.append(tensor(uniform(300 + len(self.all), shape, 0.5), True))
        return self.all[-1]


def dense(p, x, outputs):
    weight, bias = p.take(x.shape[-1], outputs), p.take(outputs)
    return x @ weight + bias


def absent(positions):
    """[BATCH, positions] bool; sample 3 has nothing."""
    b, i = np.mgrid[0:BATCH, 0:positions]
    mask = (b * 5 + i * 3) % 4 == 0
    mask[3] = True
    return torch.tensor(mask)


def attend(q, k, v, heads, key_dim, groups, causal, masked):
    def split(x):  # [B, groups, heads, positions, key_dim]
        return x.reshape(BATCH, groups, -1, heads, key_dim).transpose(2, 3)
    q, k, v = split(q), split(k), split(v)
    score = q @ k.transpose(-1, -2) / math.sqrt(key_dim)
    hidden = torch.zeros(score.shape, dtype=torch.bool)
    if causal:
        hidden |= torch.ones(score.shape[-2:], dtype=torch.bool).triu(1)
    if masked is not None:
        hidden |= masked.reshape(BATCH, groups, 1, 1, -1)
    weight = torch.softmax(score.masked_fill(hidden, -1e300), -1).masked_fill(hidden, 0.0)
    return (weight @ v).transpose(2, 3).reshape(BATCH, -1, heads * key_dim)


def attention(p, query, keys, heads, key_dim, outputs, groups=1, causal=False, masked=None):
    q = dense(p, query, heads * key_dim)
    k = keys @ p.take(keys.shape[-1], heads * key_dim)
    v = dense(p, keys, heads * key_dim)
    return dense(p, attend(q, k, v, heads, key_dim, groups, causal, masked), outputs)


def inputs(salt, positions, features):
    return tensor(uniform(salt, (BATCH, positions, features)))


def dense_case(p):
    return dense(p, dense(p, inputs(200, 3, 7), 21), 5)


def activations_case(p):
    hidden = dense(p, inputs(200, 3, 7), 21)
    return F.relu(hidden) + torch.tanh(hidden)


def layer_norm_case(p):
    hidden = dense(p, inputs(200, 3, 7), 21)
    gain, bias = p.take(21), p.take(21)
    return F.layer_norm(hidden, (21,), 1 + gain, bias)


def embed_case(p):
    index = torch.tensor((np.arange(BATCH * 3) * 7 % 13).reshape(BATCH, 3))
    return p.take(11, 20)[index.clamp(max=10)]


def structure_case(p):
    a, b = dense(p, inputs(200, 3, 7), 9), dense(p, inputs(201, 3, 4), 13)
    joined = torch.cat([a, b], -1)
    other = dense(p, inputs(202, 2, 5), 22)
    return torch.stack([joined[:, 2], other[:, 0], joined[:, 0], other[:, 1], joined[:, 2]], 1)


def max_pool_case(p):
    hidden = dense(p, inputs(200, 8, 7), 19)
    return torch.cat([hidden.masked_fill(absent(8).unsqueeze(-1), -math.inf).reshape(BATCH, 2, 4, 19).amax(2)
                      .nan_to_num(neginf=0.0)], 1)


def attention_case(p):
    query, keys = inputs(200, 6, 7), inputs(201, 10, 9)
    return attention(p, dense(p, query, 12), dense(p, keys, 18), 2, 16, 10, groups=2, masked=absent(10))


def causal_case(p):
    hidden = dense(p, inputs(200, 20, 7), 16)
    return attention(p, hidden, hidden, 1, 32, 16, causal=True)


if __name__ == '__main__':
    for case in (dense_case, activations_case, layer_norm_case, embed_case, structure_case, max_pool_case,
                 attention_case, causal_case):
        name = 'graph/' + case.__name__[:-len('_case')]
        p = Parameters()
        output = case(p)
        (output * tensor(uniform(250, tuple(output.shape)))).sum().backward()
        save(name + '/output', output)
        save(name + '/gradient', flat([value.grad for value in p.all]))
